"""An app that drives, and after a while goes wrong as it is told to."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from threading import Event
from typing import Literal

from benchmarks.ways.witness import Log
from robotcore import Behaviour, Robot, Role, Status


@dataclass
class GoWrong(Behaviour):
    """Drives a curve; after ``after_s`` seconds it does as ``way`` says, and notes in ``log`` when."""

    log: str = ""
    way: Literal["goes on", "raises", "waits", "burns", "is deaf"] = "goes on"
    after_s: float = 1.0
    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})

    def step(self, robot: Robot) -> Status:
        robot.camera.read()
        robot.drive.set_velocity(0.1, 0.2)
        if self.way != "goes on" and robot.clock.now() >= self.after_s:
            Log(self.log).note("event")
            self._go_wrong()
        return Status.RUNNING

    def _go_wrong(self) -> None:
        if self.way == "raises":
            raise RuntimeError("gone wrong")
        while self.way == "burns":
            pass
        while self.way == "waits":
            Event().wait()
        while True:  # deaf
            with suppress(BaseException):
                Event().wait()
