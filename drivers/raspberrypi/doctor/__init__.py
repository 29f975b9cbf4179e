"""The checks of `robotcore doctor` on a Raspberry Pi.

The parameter ``root`` of a check is the root of the file system. Tests pass a folder with the files of a board.
"""

from drivers.raspberrypi.doctor.board import is_raspberry_pi
from drivers.raspberrypi.doctor.examination import examine

__all__ = ["examine", "is_raspberry_pi"]
