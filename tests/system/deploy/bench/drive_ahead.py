"""Drives straight ahead, and fails on request: by its setting, or by a file in the home folder."""

import os
import time
from dataclasses import dataclass
from math import nan
from pathlib import Path

from robotcore import Behaviour, Robot, Role, Status

FAULT_FILE = Path.home() / "fault"
"""A file with the name of a failure. The app fails so in its next tick, and deletes the file."""

NOTE_FILE = Path.home() / "noted"


@dataclass
class DriveAhead(Behaviour):
    """Drives at ``speed_rad_s``, fails as ``fault`` says in its tick ``at``, and writes ``note`` into a file."""

    needs = frozenset({Role.DRIVE})

    speed_rad_s: float = 2.0
    fault: str = ""
    at: int = 1
    note: str = ""

    def __post_init__(self) -> None:
        self._ticks = 0
        NOTE_FILE.write_text(self.note)
        if self.fault == "no-start":
            time.sleep(3600)

    def step(self, robot: Robot) -> Status:
        self._ticks += 1
        if self._ticks == self.at and self.fault:
            self._fail(self.fault)
        if FAULT_FILE.exists():
            fault = FAULT_FILE.read_text().strip()
            FAULT_FILE.unlink()
            self._fail(fault)
        robot.drive.set_wheels(self.speed_rad_s, self.speed_rad_s)
        return Status.RUNNING

    def _fail(self, fault: str) -> None:
        if fault == "raise":
            raise ValueError("no ball today")
        if fault == "exit":
            os._exit(9)
        if fault == "invalid-speed":
            self.speed_rad_s = nan
        while fault == "hang":
            time.sleep(0.01)
