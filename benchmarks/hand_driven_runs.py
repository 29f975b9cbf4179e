"""Check that hand-driven runs are replayed bit for bit.

    python -m benchmarks.hand_driven_runs --runs 50 --seed 1

In each run, a thread drives at random times of the machine's clock: velocities, some of them NaN, commands to a servo,
a light and a buzzer, silence, and releases, after which the app continues. The app, the backend, the world and the
faults are drawn from the seed. The run is recorded to a file, read back, and replayed. The exit status is 1 if a replay
differs.
"""

from __future__ import annotations

import math
import random
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread

from benchmarks.report import parse_options, print_table
from robotcore.errors import InvalidCommandError
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay import ReplayResult, replay
from robotcore.runtime.observer import RunContext
from robotcore.runtime.operator_input import LEASE_S
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import run
from robotcore.runtime.trace import TickRecord
from robotcore.threads import start_thread
from tests.robotcore.description.files import ROVER

RANDOM_MANOEUVRES = str(Path(__file__).with_name("random_manoeuvres.py"))
APPS = ("green-search", "avoid-obstacles", "teleop", RANDOM_MANOEUVRES)
FAULTS = (
    "operator drop=0.3",
    "operator delay=0.2",
    "operator freeze after=1 lasts=0.4",
    "operator noise=0.05 field=linear",
    "nose freeze after=2 lasts=0.6",
    "range noise=0.05",
    "range spikes=0.1",
    "left_motor weak=0.6",
    "right_motor dead after=3",
    "encoders slip=0.1",
    "loop stall=0.3 every=1.5",
    "connection lost=2 after=3",
)
EQUIPMENT = """
[[devices]]
kind = "servo"
name = "pan"
min_angle_rad = -1.0
max_angle_rad = 1.0
max_velocity_rad_s = 5.0

[[devices]]
kind = "led"
name = "lamp"
is_rgb = true

[[devices]]
kind = "buzzer"
name = "horn"
"""
PAUSE_S = 0.03
"""The longest pause between two actions of the person, in seconds."""


class RandomPerson:
    """An observer whose thread drives at random times."""

    def __init__(self, draw: random.Random) -> None:
        self._draw = draw
        self._has_ended = Event()
        self._thread: Thread | None = None

    def begin(self, context: RunContext) -> None:
        self._context = context
        self._thread = start_thread(self._drive, "person")

    def tick(self, record: TickRecord) -> None:
        """Do nothing: the thread drives."""

    def end(self, result: RunResult) -> None:
        self._has_ended.set()
        if self._thread:
            self._thread.join()

    def _drive(self) -> None:
        draw = self._draw
        while not self._has_ended.wait(draw.uniform(0, PAUSE_S)):
            operator = self._context.operator
            assert operator
            chance = draw.random()
            if chance < 0.6:
                operator.drive(draw.uniform(-0.3, 0.5), draw.uniform(-3, 3))
            elif chance < 0.65:
                with suppress(InvalidCommandError):
                    operator.drive(math.nan, 0.0)
            elif chance < 0.8 and operator.actuators:
                device = draw.choice(operator.actuators)
                colours = [draw.random() for _ in range(3)]
                operator.command(device, colours if device == "lamp" else draw.uniform(0, 2))
            elif chance < 0.85:
                self._has_ended.wait(LEASE_S + PAUSE_S)
            else:
                operator.release()
                self._has_ended.wait(draw.uniform(0, 2 * PAUSE_S))


@dataclass(frozen=True)
class Case:
    """A hand-driven run that was recorded and replayed."""

    request: RunRequest
    replayed: ReplayResult

    @property
    def is_bit_equal(self) -> bool:
        return self.replayed.is_equal and self.replayed.is_exact

    @property
    def states(self) -> list[str]:
        """The state of the person in each tick: ``driving``, ``silent`` or ``""``."""
        samples = self.replayed.recording.samples
        keys = (read.key for tick in self.replayed.recording.ticks for read in tick.reads if read.device == "operator")
        found = [samples[key] for key in keys if key]
        return ["silent" if each.is_silent else "driving" if each.is_driving else "" for each in found]  # type: ignore[attr-defined]  # samples of the operator


def main() -> int:
    """Record and replay every run, and print the number of equal replays."""
    options = parse_options(__doc__, runs=50, seed=1, backends="kinematic,mujoco,pybullet")
    backends, cases = options.backends.split(","), []
    with TemporaryDirectory() as folder:
        robot = Path(folder) / "equipped.toml"
        robot.write_text(ROVER + EQUIPMENT)
        for index in range(options.runs):
            draw = random.Random(options.seed * 1000 + index)
            request = _draw_request(draw, backends[index % len(backends)], str(robot))
            cases.append(_run_case(request, RandomPerson(draw), Path(folder) / "run.mcap"))
    columns = ("backend", "runs", "with faults", "ticks", "driven by hand", "changes", "commands", "bit-equal")
    print_table(columns, _build_rows(cases))
    equal = sum(case.is_bit_equal for case in cases)
    print(f"\n{equal} of {len(cases)} bit-equal")
    for case in cases:
        if not case.is_bit_equal:
            print(f"differs: {case.request}\n{case.replayed.deviation}")
    return int(equal != len(cases))


def _draw_request(draw: random.Random, backend: str, robot: str) -> RunRequest:
    app = draw.choice(APPS)
    return RunRequest(
        app,
        backend,
        robot if app == "teleop" else "rover",
        draw.choice(("open", "arena", "clutter")),
        draw.randrange(1000),
        timeout_s=draw.uniform(10, 40),
        settings={"seed": draw.randrange(1000)} if app == RANDOM_MANOEUVRES else {},
        faults=tuple(draw.sample(FAULTS, draw.randrange(3))),
        has_operator=True,
    )


def _run_case(request: RunRequest, person: RandomPerson, file: Path) -> Case:
    recorder = Recorder(file)
    run(request, [recorder, person], [recorder.layer])
    if recorder.failure:
        raise recorder.failure
    return Case(request, replay(read(file), file))


def _build_rows(cases: list[Case]) -> Iterator[tuple[str, ...]]:
    groups: dict[str, list[Case]] = defaultdict(list)
    for case in cases:
        groups[case.request.backend].append(case)
    for backend, group in sorted(groups.items()):
        states = [case.states for case in group]
        changes = sum(bool(a) != bool(b) for each in states for a, b in pairwise(each))
        ticks = [tick for case in group for tick in case.replayed.recording.ticks]
        yield (
            backend,
            str(len(group)),
            str(sum(bool(case.request.faults) for case in group)),
            str(len(ticks)),
            str(sum(bool(state) for each in states for state in each)),
            str(changes),
            str(sum(len(tick.commands) for tick in ticks)),
            f"{sum(case.is_bit_equal for case in group)}/{len(group)}",
        )


if __name__ == "__main__":
    sys.exit(main())
