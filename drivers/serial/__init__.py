"""Boards and sensors on a serial line: usable in any robot's section, and the whole robot of the backend `serial`."""
