"""A run with real-time priority whose app hangs: in Python, or in C with the interpreter's lock."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

from benchmarks.logging_robot import LoggingBackend
from robotcore.hal.robot import Robot, Role
from robotcore.hal.wall_clock import read_timer
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.request import RunRequest
from robotcore.runtime.session import run
from robotcore.safety.real_time import read_priority_and_locked_memory
from tests.robotcore.safety.guardian.recorder import notes

HANG_AT = 5
COUNT = 10**12
"""So many numbers that their sum has no end in time."""


def write_event(**values: object) -> None:
    sys.stdout.write(f"{json.dumps(values)}\n")
    sys.stdout.flush()


@dataclass
class HungApp(Behaviour):
    """Drives, then hangs in its fifth tick."""

    needs = frozenset({Role.DRIVE})
    way: str = "python"
    ticks: int = 0
    hung_at: float = 0.0
    diary: Path = Path()

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.1, 0.0)
        self.ticks += 1
        if self.ticks == HANG_AT:
            assert read_priority_and_locked_memory()["priority"] == 20
            self.hung_at = read_timer()
            write_event(event="hangs", time=self.hung_at, diary=str(self.diary))
            while self.way == "python":
                pass
            sum(range(COUNT))  # a loop in C, which neither gives the lock away nor handles signals
        return Status.RUNNING


def main() -> None:
    """Execute the run. The way to hang is a line on standard input."""
    app = HungApp(way=sys.stdin.readline().strip())
    with TemporaryDirectory() as folder, patch("robotcore.runtime.plan.load_backend", lambda _: LoggingBackend()):
        diary = app.diary = Path(folder, "diary")
        result = run(
            RunRequest(app, "logging", options={"diary": str(diary), "is_guarded": True}, has_real_time_priority=True)
        )
        stops = [note.time for note in notes(diary) if note.action.startswith(("stand", "stop"))]
    stopped = min(time for time in stops if time >= app.hung_at) - app.hung_at
    write_event(outcome=result.outcome.value, notes=result.notes, stopped_s=stopped)


if __name__ == "__main__":
    main()
