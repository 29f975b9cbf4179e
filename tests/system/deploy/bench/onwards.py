"""Drives, and does by its setting, or when somebody asks for it, what no app should."""

import os
import time
from dataclasses import dataclass
from math import nan
from pathlib import Path

from robotcore import Behaviour, Robot, Role, Status

ASKED = Path.home() / "deed"
"""Names what is to be done at once, once."""

NOTED = Path.home() / "noted"


@dataclass
class Onwards(Behaviour):
    """Drives at ``speed_rad_s``, does the deed in its tick ``at``, and writes down the ``note`` that it was given."""

    needs = frozenset({Role.DRIVE})

    speed_rad_s: float = 2.0
    deed: str = ""
    at: int = 1
    note: str = ""

    def __post_init__(self) -> None:
        self._ticks = 0
        NOTED.write_text(self.note)
        if self.deed == "dawdles":
            time.sleep(3600)

    def step(self, robot: Robot) -> Status:
        self._ticks += 1
        if self._ticks == self.at and self.deed:
            self._do(self.deed)
        if ASKED.exists():
            deed = ASKED.read_text().strip()
            ASKED.unlink()
            self._do(deed)
        robot.drive.set_wheels(self.speed_rad_s, self.speed_rad_s)
        return Status.SUCCESS if self._ticks == self.at and self.deed == "arrives" else Status.RUNNING

    def _do(self, deed: str) -> None:
        if deed == "raises":
            raise ValueError("no ball today")
        if deed == "leaves":
            os._exit(9)
        if deed == "errs":
            self.speed_rad_s = nan
        while deed == "hangs":
            time.sleep(0.01)
