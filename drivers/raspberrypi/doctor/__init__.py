"""What is right and what is wrong with a Raspberry Pi that is to drive a robot; a file for each subject.

Each check is a function of the root of the file system, so that a made-up tree of files stands in for a board.
"""

from drivers.raspberrypi.doctor.board import is_raspberry_pi
from drivers.raspberrypi.doctor.examination import examine

__all__ = ["examine", "is_raspberry_pi"]
