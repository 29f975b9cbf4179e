"""Boards and sensors on a serial line: the backend `serial`, and device drivers for any backend with real hardware."""
