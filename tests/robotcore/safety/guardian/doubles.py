"""A robot whose motors record their commands, and runs of it in processes of their own."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.motor import Motor
from tests.robotcore.safety.guardian.recorder import Diary, notes

UNGUARDED = "unguarded"

MOTORS = ("left_motor", "right_motor", "gripper")


class RecordingMotor(Motor):
    """Records whether it turns. If ``are_stuck`` is set, every call that stops a motor hangs."""

    are_stuck = False

    def __init__(self, name: str, diary: Diary) -> None:
        super().__init__(name, 12.0)
        self._diary = diary

    def _apply(self, rad_s: float) -> None:
        if self.are_stuck and not rad_s:
            threading.Event().wait()
        self._diary.note(f"{'turn' if rad_s else 'stand'} {self.name}")


class RecordingBackend(Backend):
    """Opens two wheel motors and a gripper, in real time. With the manner `UNGUARDED` it has no cutoffs."""

    name = "recording"
    summary = "motors that record their commands"

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


ROOT = Path(__file__).parents[4]
END_S = 60.0


class Running:
    """A run in another process. Its diary contains the commands to the motors and to the cutoffs."""

    def __init__(self, app: str, diary: Path, *manner: str) -> None:
        self.diary = diary
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.robotcore.safety.guardian.guarded_run", app, str(diary), *manner],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        assert self.process.stdout
        assert self.process.stdout.readline() == "moving\n"

    def end(self) -> tuple[str, str]:
        """Wait until the run and its guardian have ended. Return stdout and stderr."""
        return self.process.communicate(timeout=END_S)

    def read_result(self) -> dict[str, Any]:
        """Return the run's result from its JSON."""
        out, err = self.end()
        assert not err
        result: dict[str, Any] = json.loads(out)
        return result

    @property
    def actions(self) -> list[str]:
        return [note.action for note in notes(self.diary)]

    @property
    def guardian(self) -> int:
        """Return the number of the guardian's process."""
        return next(note.process for note in notes(self.diary) if note.action.startswith("open"))


Start = Callable[..., Running]
