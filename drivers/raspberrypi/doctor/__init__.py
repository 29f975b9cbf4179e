"""The doctor's checks of a Raspberry Pi; a file for each subject.

Each check takes the root of the file system, so that tests can replace a board by a tree of files.
"""

from drivers.raspberrypi.doctor.board import is_raspberry_pi
from drivers.raspberrypi.doctor.examination import examine

__all__ = ["examine", "is_raspberry_pi"]
