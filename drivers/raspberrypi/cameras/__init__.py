"""Cameras: on the Pi's ribbon connector by picamera2, on USB by V4L2; what both share lies beside them."""
