"""A file in which several processes note what motors were told, and by whom."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import NamedTuple


class Note(NamedTuple):
    """At which time of the machine's, by which process, and what: ``"turn left_motor"``."""

    time: float
    process: int
    what: str


class Diary:
    """Adds notes, whole lines each."""

    def __init__(self, file: str | Path) -> None:
        self._handle = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)

    def note(self, what: str) -> None:
        os.write(self._handle, json.dumps([time.monotonic(), os.getpid(), what]).encode() + b"\n")

    def close(self) -> None:
        os.close(self._handle)


def notes(file: Path) -> list[Note]:
    return [Note(*json.loads(line)) for line in file.read_text().splitlines()]
