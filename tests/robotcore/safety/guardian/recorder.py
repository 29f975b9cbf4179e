"""A file in which several processes record the actions of motors and cutoffs, and a cutoff that records its actions."""

from __future__ import annotations

import json
import os
import threading
import time
from pathlib import Path
from typing import NamedTuple

from robotcore.hal.cutoff import Cutoff, UnconfirmedStop
from robotcore.hal.wall_clock import MonotonicClock


class Note(NamedTuple):
    """An entry of a diary."""

    time: float
    """The time of the machine's monotonic clock, in seconds."""

    process: int
    """The number of the process."""

    action: str
    """An action and a device, such as ``turn left_motor``."""


class Diary:
    """Appends notes to a file, a line each."""

    def __init__(self, file: str | Path) -> None:
        self._handle = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)

    def note(self, action: str) -> None:
        os.write(self._handle, json.dumps([time.monotonic(), os.getpid(), action]).encode() + b"\n")

    def close(self) -> None:
        os.close(self._handle)


def notes(file: Path) -> list[Note]:
    return [Note(*json.loads(line)) for line in file.read_text().splitlines()]


SLOW_S = 0.3


class Recorder(Cutoff):
    """Records its actions. ``manner`` names the action that fails, hangs or is slow, such as ``fails to stop``."""

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
        return UnconfirmedStop("the port is gone") if self._manner == "is unsure" else None

    def close(self) -> None:
        self._do("close")
        self._diary.close()

    def _do(self, action: str) -> None:
        if self._manner == f"fails to {action}":
            raise OSError(f"no {action}")
        if self._manner == f"hangs in {action}":
            threading.Event().wait()
        if self._manner == f"is slow to {action}":
            MonotonicClock().sleep_until(SLOW_S)
        self._diary.note(f"{action} {self._device}")
