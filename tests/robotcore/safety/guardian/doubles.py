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
from robotcore.hal.devices import Motor
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from tests.robotcore.safety.guardian.recorder import Diary, notes

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


ROOT = Path(__file__).parents[4]
END_S = 60.0


class Running:
    """A run that drives; what is told of motors is in its diary."""

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
        """Return what it has printed, once neither it nor its guardian is there any more, for both hold its stderr."""
        return self.process.communicate(timeout=END_S)

    def read_result(self) -> dict[str, Any]:
        """Return how it ended."""
        out, err = self.end()
        assert not err
        result: dict[str, Any] = json.loads(out)
        return result

    @property
    def deeds(self) -> list[str]:
        return [note.what for note in notes(self.diary)]

    @property
    def guardian(self) -> int:
        """The number of the guardian's process."""
        return next(note.process for note in notes(self.diary) if note.what.startswith("open"))


Start = Callable[..., Running]
