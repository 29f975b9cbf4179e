"""The recordings of a corpus: how each is made, in a folder with the sources."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robotcore import RunRequest, run
from robotcore.recording.recorder import Recorder
from robotcore.recording.segments import locate_segments
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord

SURVEY = "survey.py"
EVERYTHING: dict[str, Any] = {"app": SURVEY, "robot": "everything.toml", "world": "hall.toml", "seed": 3}
SKIDDING: dict[str, Any] = {**EVERYTHING, "robot": "skidding.toml"}
RING_S = 1.0
"""The length of the ring of a flight recorder, in seconds."""

KILLED_PROGRAM = """
import sys
from tests.compatibility.recordings import record_until_killed
record_until_killed()
"""
KILLED_AFTER_S = 3.0


class Person:
    """An observer that drives for a second, commands a light, lets go, and drives again."""

    def begin(self, context: RunContext) -> None:
        self._operator = context.operator

    def tick(self, record: TickRecord) -> None:
        assert self._operator
        if record.time < 1.0 or record.time > 1.5:
            self._operator.drive(0.2, 0.5)
        elif record.time > 1.2:
            self._operator.release()
        if 0.5 < record.time < 0.6 and "lamp" in self._operator.actuators:
            self._operator.command("lamp", [0.1, 0.2, 0.3])

    def end(self, result: RunResult) -> None:
        """Do nothing: the run has stopped the wheels."""


class Button:
    """An observer that presses the e-stop after a second."""

    def begin(self, context: RunContext) -> None:
        self._context = context

    def tick(self, record: TickRecord) -> None:
        if record.time >= 0.5:
            self._context.emergency.press("the button was pressed")

    def end(self, result: RunResult) -> None:
        """Do nothing."""


@dataclass(frozen=True)
class Recipe:
    """A run to record."""

    request: dict[str, Any]
    observer: Callable[[], Any] | None = None
    recorder: dict[str, Any] = field(default_factory=dict)


RECIPES = {
    "avoid-obstacles": Recipe({"app": "avoid-obstacles", "seed": 7, "settings": {"duration_s": 2.0}}),
    "green-search": Recipe({**EVERYTHING, "app": "green-search", "timeout_s": 3.0}),
    "everything": Recipe(EVERYTHING),
    "randomised": Recipe({**EVERYTHING, "randomise": True}),
    "skidding": Recipe(SKIDDING),
    "steering": Recipe({**EVERYTHING, "robot": "steering.toml"}),
    "battery": Recipe({"app": SURVEY, "robot": "skidding.toml", "backend": "mock"}),
    "pins": Recipe({**EVERYTHING, "app": "avoid-obstacles", "backend": "virtualpi", "settings": {"duration_s": 1.0}}),
    "faults": Recipe(
        {
            **EVERYTHING,
            "faults": (
                "camera drop=0.3",
                "range noise=0.02",
                "imu noise=0.05 field=yaw_rate",
                "left_motor weak=0.7",
                "front stuck=1 field=is_pressed after=1",
                "nose freeze after=1 lasts=0.5",
                "connection lost=0.3 after=1",
            ),
        }
    ),
    "driven": Recipe({**EVERYTHING, "has_operator": True, "timeout_s": 2.0}, observer=Person),
    "stopped": Recipe(SKIDDING, observer=Button),
    "invalid-command": Recipe({**SKIDDING, "settings": {"ending": "nan", "duration_s": 0.5}}),
    "exception": Recipe({**SKIDDING, "settings": {"ending": "exception", "duration_s": 0.5}}),
    "failure": Recipe({**SKIDDING, "settings": {"ending": "failure", "duration_s": 0.5}}),
    "jpeg": Recipe(EVERYTHING, recorder={"is_jpeg": True}),
    "ring": Recipe({**EVERYTHING, "settings": {"duration_s": 15.0}, "timeout_s": 20.0}, recorder={"last_s": RING_S}),
}


def record_all(folder: Path) -> None:
    """Record each recipe into a folder, and a flight recorder whose process is killed."""
    for name, recipe in RECIPES.items():
        recorder = Recorder(folder / f"{name}.mcap", **recipe.recorder)
        observers = [recorder, recipe.observer()] if recipe.observer else [recorder]
        run(RunRequest(**recipe.request), observers, [recorder.layer])
        assert recorder.failure is None, f"{name}: {recorder.failure}"
    _record_killed(folder / "killed.mcap")


def record_until_killed() -> None:
    """Record a flight recorder into the file of the first argument. Print a line for each tick."""
    recorder = Recorder(Path(sys.argv[1]), last_s=RING_S)

    class Printer(Button):
        def tick(self, record: TickRecord) -> None:
            sys.stdout.write(f"{record.time}\n")
            sys.stdout.flush()

    request = {**EVERYTHING, "settings": {"duration_s": 60.0}, "timeout_s": 60.0, "realtime": True}
    run(RunRequest(**request), [recorder, Printer()], [recorder.layer])


def _record_killed(file: Path) -> None:
    """Record until the process is killed. Its segments stay beside the file."""
    command = [sys.executable, "-c", KILLED_PROGRAM, str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        for line in process.stdout:
            if float(line) > KILLED_AFTER_S:
                break
        process.send_signal(signal.SIGKILL)
    assert any(locate_segments(file).iterdir())
