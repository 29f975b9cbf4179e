"""Runs in processes of their own, on a robot that notes what its motors are told."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.robotcore.safety.guardian.diary import notes

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

    def told(self) -> dict[str, Any]:
        """Return how it ended."""
        out, err = self.end()
        assert not err
        told: dict[str, Any] = json.loads(out)
        return told

    @property
    def deeds(self) -> list[str]:
        return [note.what for note in notes(self.diary)]

    @property
    def guardian(self) -> int:
        """The number of the guardian's process."""
        return next(note.process for note in notes(self.diary) if note.what.startswith("open"))


Start = Callable[..., Running]
