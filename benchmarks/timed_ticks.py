"""A run of `benchmarks.jitter`: it writes the beginnings of its ticks as one line of JSON.

    python -m benchmarks.timed_ticks '{"rate_hz": 50, "ticks": 500, "rt": true, "is_pinned": false}'

The robot has a guardian, motors that note their commands, and constant encoders that are read 200 times in a second.
"""

from __future__ import annotations

import json
import os
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


class PolledBackend(LoggingBackend):
    """The robot, with encoders that are read beside the app."""

    encoder_rate_hz = 200.0


@dataclass
class TimedTicks(Behaviour):
    """Turns on the spot, and notes the beginning of each tick."""

    needs = frozenset({Role.DRIVE})
    ticks: int = 100
    is_pinned: bool = False

    def __post_init__(self) -> None:
        self.times: list[float] = []
        self.granted: dict[str, int] = {}

    def step(self, robot: Robot) -> Status:
        self.times.append(read_timer())
        if len(self.times) == 2 and self.is_pinned:
            os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # the calling thread alone
        robot.drive.set_velocity(0.0, 0.5 if len(self.times) % 20 < 10 else -0.5)  # constant encoders do not follow
        if len(self.times) <= self.ticks:
            return Status.RUNNING
        self.granted = read_priority_and_locked_memory()
        return Status.SUCCESS


def main() -> None:
    """Execute the run."""
    wanted = json.loads(sys.argv[1])
    app = TimedTicks(ticks=wanted["ticks"], is_pinned=wanted["is_pinned"])
    with TemporaryDirectory() as folder, patch("robotcore.runtime.plan.load_backend", lambda _: PolledBackend()):
        request = RunRequest(
            app,
            "logging",
            rate_hz=wanted["rate_hz"],
            timeout_s=600.0,
            options={"diary": str(Path(folder, "diary")), "is_guarded": True},
            has_real_time_priority=wanted["rt"],
        )
        result = run(request)
    print(json.dumps({"times": app.times, "overruns": result.overruns, "notes": result.notes, **app.granted}))


if __name__ == "__main__":
    main()
