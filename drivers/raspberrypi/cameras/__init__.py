"""Cameras: on the Pi's ribbon connector by picamera2, and on USB by V4L2."""
