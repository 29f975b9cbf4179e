"""A cutoff that notes what the guardian does, and may do it badly."""

from __future__ import annotations

import threading

from robotcore.hal.cutoff import Cutoff, Unsure
from robotcore.hal.wall_clock import MonotonicClock
from tests.robotcore.safety.guardian.diary import Diary

SLOW_S = 0.3


class Recorder(Cutoff):
    """Notes what it is asked for, and fails where its ``manner`` has it so."""

    def __init__(self, diary: str, device: str, manner: str = "good") -> None:
        self._diary, self._device, self._manner = Diary(diary), device, manner
        self._stops = 0

    def open(self) -> None:
        self._do("open")

    def arm(self) -> None:
        self._do("arm")

    def stop(self) -> str | None:
        self._stops += 1
        if self._manner == "late" and self._stops < 3:
            raise OSError("the line is busy")
        self._do("stop")
        return Unsure("nobody can tell") if self._manner == "is unsure" else None

    def close(self) -> None:
        self._do("close")
        self._diary.close()

    def _do(self, deed: str) -> None:
        if self._manner == f"fails to {deed}":
            raise OSError(f"no {deed}")
        if self._manner == f"hangs in {deed}":
            threading.Event().wait()
        if self._manner == f"is slow to {deed}":
            MonotonicClock().sleep_until(SLOW_S)
        self._diary.note(f"{deed} {self._device}")
