"""A robot whose motors only note what they are told, and whose cutoffs note what the guardian does."""

from __future__ import annotations

import threading
from pathlib import Path

from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Motor
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from tests.robotcore.safety.guardian.diary import Diary

UNGUARDED = "unguarded"

MOTORS = ("left_motor", "right_motor", "gripper")


class RecordingMotor(Motor):
    """Notes whether it turns; no motor can be stopped any more where they ``are_stuck``."""

    are_stuck = False

    def __init__(self, name: str, diary: Diary) -> None:
        super().__init__(name, 12.0)
        self._diary = diary

    def _apply(self, rad_s: float) -> None:
        if self.are_stuck and not rad_s:
            threading.Event().wait()
        self._diary.note(f"{'turn' if rad_s else 'stand'} {self.name}")


class RecordingBackend(Backend):
    """Opens the motors of any robot, and one more; its clock is the machine's own. It may have no guardian."""

    name = "recording"
    summary = "motors that note what they are told"

    def __init__(self, diary: Path, manner: str = "good") -> None:
        self._file, self._manner = diary, manner

    def open(self, setup: Setup) -> Robot:
        diary = Diary(self._file)
        return Robot(
            "recorder",
            MonotonicClock(),
            [RecordingMotor(name, diary) for name in MOTORS],
            release=diary.close,
            cutoffs=[cutoff(self._file, name, self._manner) for name in MOTORS if self._manner != UNGUARDED],
        )


def cutoff(diary: Path, device: str = "left_motor", manner: str = "good") -> CutoffSpec:
    parameters = {"diary": str(diary), "device": device, "manner": manner}
    return CutoffSpec(device, "tests.robotcore.safety.guardian.recorder:Recorder", parameters)
