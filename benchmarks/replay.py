"""Check that recorded runs are replayed bit for bit, on each backend and with each kind of ending.

    python -m benchmarks.replay --runs 100 --seed 1
    python -m benchmarks.replay --runs 100 --seed 1 --apps random-manoeuvres   # an app of composed generators

Each run is drawn from the seed: its app, backend, world, faults and disturbance. It is recorded to a file, read back,
and replayed. The benchmark prints each deviation with its run. The exit status is 1 if a replay differs.
"""

from __future__ import annotations

import random
import signal
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.report import parse_options, print_table
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay import ReplayResult, replay
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.session import run
from tests.robotcore.recording.replay.memory import Disturbance, press_emergency_stop, send_signal

CLUMSY = str(Path(__file__).with_name("clumsy_search.py"))
RANDOM_MANOEUVRES = str(Path(__file__).with_name("random_manoeuvres.py"))
APPS = {
    "green-search": "green-search",
    "avoid-obstacles": "avoid-obstacles",
    "mark-green": "mark-green",
    "clumsy": CLUMSY,
    "random-manoeuvres": RANDOM_MANOEUVRES,
}
"""The apps to record, by their names in ``--apps``."""
FAULTS = (
    "camera drop=0.3",
    "camera delay=0.2",
    "camera noise=20",
    "nose freeze after=2 lasts=0.6",
    "nose freeze after=3",
    "range noise=0.05",
    "range spikes=0.1",
    "range no_echo=0.3",
    "left_motor weak=0.6",
    "right_motor dead after=3",
    "encoders slip=0.1",
    "loop stall=0.3 every=1.5",
    "connection lost=2 after=3",
)
DISTURBANCES = (
    partial(Disturbance, disturb=press_emergency_stop),
    partial(Disturbance, disturb=press_emergency_stop, is_in_tick=True),
    partial(Disturbance, disturb=send_signal(signal.SIGINT)),
    partial(Disturbance, disturb=send_signal(signal.SIGTERM), is_in_tick=True),
)


@dataclass(frozen=True)
class Case:
    """A run that was recorded and replayed, with both times in seconds."""

    request: RunRequest
    replayed: ReplayResult
    recording_s: float
    replay_s: float

    @property
    def ending(self) -> str:
        """The outcome of the run, and the class of its error if it has one."""
        result = self.replayed.recording.result
        assert result, "a run that is recorded here is recorded to its end"
        last = self.replayed.recording.ticks[-1].error
        return f"{result.outcome.value}, {last.kind}" if last else result.outcome.value

    @property
    def is_bit_equal(self) -> bool:
        return self.replayed.is_equal and self.replayed.is_exact


def main() -> int:
    """Record and replay every run, and print the number of equal replays."""
    options = parse_options(__doc__, runs=100, seed=1, backends="kinematic,pybullet", apps=",".join(APPS))
    draw = random.Random(options.seed)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        cases = [
            _run_case(*_draw_run(draw, options.backends.split(","), options.apps.split(",")), file)
            for _ in range(options.runs)
        ]
    print_table(("backend", "ended by", "runs", "faults", "interventions", "ticks", "bit-equal"), _build_rows(cases))
    equal = sum(case.is_bit_equal for case in cases)
    pace = sum(case.recording_s for case in cases) / sum(case.replay_s for case in cases)
    print(f"{equal} of {len(cases)} bit-equal; a replay takes 1/{pace:.1f} of the time of its run")
    for case in cases:
        if not case.is_bit_equal:
            print(f"differs: {case.request}\n{case.replayed.deviation}")
    return int(equal != len(cases))


def _draw_run(draw: random.Random, backends: list[str], apps: list[str]) -> tuple[RunRequest, Disturbance | None]:
    app = APPS[draw.choice(apps)]
    backend, seed, timeout_s = draw.choice(backends), draw.randrange(1000), draw.uniform(4, 12)
    if app == "mark-green":
        return RunRequest(app, backend, "lookout", "open", seed, timeout_s=timeout_s), None
    settings: dict[str, object] = {}
    if app == CLUMSY:
        settings = {"by": draw.choice(("raise", "nan")), "at": draw.randrange(10, 80)}
    elif app == RANDOM_MANOEUVRES:
        settings = {"seed": draw.randrange(1000)}
    has_camera = app not in ("avoid-obstacles", RANDOM_MANOEUVRES)
    possible = [fault for fault in FAULTS if has_camera or not fault.startswith("camera")]
    faults = tuple(draw.sample(possible, draw.randrange(3)))
    disturbance = draw.choice(DISTURBANCES)(draw.randrange(5, 80)) if draw.random() < 0.3 else None
    world = draw.choice(("arena", "clutter", "occluded"))
    is_randomised = draw.random() < 0.3
    request = RunRequest(app, backend, world=world, seed=seed, timeout_s=timeout_s, settings=settings, faults=faults)
    return replace(request, randomise=is_randomised), disturbance


def _run_case(request: RunRequest, disturbance: Disturbance | None, file: Path) -> Case:
    clock, recorder = MonotonicClock(), Recorder(file)
    others = [disturbance] if disturbance else []
    run(request, [recorder, *others], [*others, recorder.layer])
    if recorder.failure:
        raise recorder.failure
    recorded = clock.now()
    replayed = replay(read(file), file)
    return Case(request, replayed, recorded, clock.now() - recorded)


def _build_rows(cases: list[Case]) -> Iterator[tuple[str, ...]]:
    groups: dict[tuple[str, str], list[Case]] = defaultdict(list)
    for case in cases:
        groups[case.request.backend, case.ending].append(case)
    for (backend, ending), group in sorted(groups.items()):
        ticks = [tick for case in group for tick in case.replayed.recording.ticks]
        yield (
            backend,
            ending,
            str(len(group)),
            str(sum(bool(case.request.faults) for case in group)),
            str(sum(len(tick.interventions) for tick in ticks)),
            str(len(ticks)),
            f"{sum(case.is_bit_equal for case in group)}/{len(group)}",
        )


if __name__ == "__main__":
    sys.exit(main())
