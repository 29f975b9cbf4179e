"""Measure the odometry with encoders that are read between two ticks, against one read a tick.

    python -m benchmarks.fast_odometry --runs 16 --seconds 10
    python -m benchmarks.fast_odometry --backends kinematic --runs 4 --seconds 5

Each run draws commands from its seed: for 0.1 to 0.6 s, each wheel turns forward or backward as fast as it can, or
stands. The same program runs twice, with `Backend.encoder_rate_hz` and with one read a tick. The error is the distance
between the pose by odometry and the true pose at the end.

In the case "quick", the wheels have no acceleration limit and a lag of 0.15 s, so they accelerate by up to 160 rad/s².
The rover's body is short and low there, so that its tyres grip. The physics engines make 2400 steps in a second there.
With 240 steps, their own error is as large as that of one read a tick: they move a body by the heading at one end of a
step. In the case "60 rad/s²", the robot is the shipped rover.

Then the script measures what the polls cost a tick of green-search, and how much they add to a recording.
The exit status is 1 if a ratio of errors is below 3 in a case with a bound, if a tick takes more than 5 % longer, or if
a recording is more than 5 % larger.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import process_time
from typing import ClassVar, NamedTuple
from unittest.mock import patch

from benchmarks.manoeuvre_runs import FIELD
from benchmarks.report import compute_median, parse_options, print_table
from drivers.kinematic.backend import KinematicBackend
from robotcore import Behaviour, Robot, Role, RunRequest, Status, run
from robotcore.description import RobotDescription, load_robot
from robotcore.geometry import wrap_angle
from robotcore.hal.backend import Setup, load_backend
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.runtime.layers.assembly import assemble
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import needed_devices
from robotcore.sweep.engine import count_cores

RATIO, COST, GROWTH = 3.0, 1.05, 1.05
"""The bounds of the ratio of the errors, of the ratio of the times of a tick, and of the sizes of the recordings."""

TICKS_HZ = (10.0, 20.0)
FINE_STEPS_HZ = 2400
ENGINES = ("mujoco", "pybullet")
QUICK, LIMITED = "quick", "60 rad/s²"
SHORT_BODY = {"centre_x_m": 0.015, "height_m": 0.04, "length_m": 0.13, "width_m": 0.12}
RECORDED = ("green-search", "avoid-obstacles")


class BangBang(Behaviour):
    """Commands each wheel to turn as fast as it can, or to stand, and changes this after random times."""

    needs: ClassVar = {Role.DRIVE}

    def __init__(self, seed: int, fastest: float, seconds: float) -> None:
        self._draw, self._fastest, self._seconds = Random(seed), fastest, seconds
        self._until, self._wheels = 0.0, (0.0, 0.0)

    def step(self, robot: Robot) -> Status:
        now = robot.clock.now()
        if now >= self._until:
            self._until = now + self._draw.uniform(0.1, 0.6)
            left, right = (self._draw.choice((-1, 0, 1)) * self._fastest for _ in range(2))
            self._wheels = left, right
        robot.drive.set_wheels(*self._wheels)
        return Status.RUNNING if now < self._seconds else Status.SUCCESS


class Case(NamedTuple):
    """A backend, a robot and a rate of the ticks."""

    backend: str
    robot: str
    motors: str
    """Either `QUICK` or `LIMITED`."""
    rate_hz: float

    @property
    def has_bound(self) -> bool:
        """Whether the error of the odometry is larger than those of a physics engine."""
        return self.motors == QUICK or self.backend not in ENGINES

    def describe(self) -> RobotDescription:
        """Return the description of the robot."""
        description = _add_encoders(load_robot(self.robot))
        if self.motors == LIMITED:
            return description
        quick = {"lag_s": 0.15}
        devices = [each.model_copy(update=quick) if each.kind == "motor" else each for each in description.devices]
        assert description.drive
        return description.model_copy(
            update={
                "devices": tuple(devices),
                "drive": description.drive.model_copy(update={"max_acceleration_rad_s2": None}),
                "body": description.body.model_copy(update=SHORT_BODY if self.robot == "rover" else {}),
            }
        )


class Errors(NamedTuple):
    """The errors of the odometry at the end of a run: the distance in metres, and that of the heading in rad."""

    distance: float
    heading: float


def main() -> int:
    """Measure the errors, the cost and the recordings, and print them."""
    options = parse_options(
        __doc__, runs=16, seconds=10.0, seed=1, backends="kinematic,virtualpi,mujoco,pybullet", pairs=12, search=10.0
    )
    cases = list(_list_cases(options.backends.split(",")))
    with ProcessPoolExecutor(count_cores()) as pool:
        measure = partial(_measure_case, range(options.seed, options.seed + options.runs), options.seconds)
        ratios = list(pool.map(measure, cases))
    columns = ("backend", "robot", "wheels", "ticks", "one read a tick", "encoder_rate_hz", "ratio", "heading")
    print_table(columns, (row for row, _ in ratios))
    is_exact = all(ratio >= RATIO for case, (_, ratio) in zip(cases, ratios, strict=True) if case.has_bound)
    cost = compute_median(_measure_cost(options.search) for _ in range(options.pairs))
    growths = {app: _measure_growth(app, options.search) for app in RECORDED}
    rows = [("time of a tick of green-search on kinematic", *cost.format_cells(".3f"), f"{COST:g}")]
    rows += [(f"size of a recording of {app}", f"{ratio:.3f}", "", f"{GROWTH:g}") for app, ratio in growths.items()]
    print_table(("ratio to one read a tick", "median", "95 % interval of it", "at most"), rows)
    return int(not is_exact or cost.median > COST or max(growths.values()) > GROWTH)


def _list_cases(backends: list[str]) -> Iterator[Case]:
    for backend in backends:
        for motors in (QUICK, LIMITED):
            yield from (Case(backend, "rover", motors, rate_hz) for rate_hz in TICKS_HZ)
    if "kinematic" in backends:
        yield from (Case("kinematic", robot, QUICK, 10.0) for robot in ("freenove-4wd", "picar"))


def _add_encoders(description: RobotDescription) -> RobotDescription:
    """Return the robot with an encoder of 960 counts on each driven wheel, if it has none."""
    drive = description.drive
    assert drive
    if drive.encoders:
        return description
    names = {motor: f"{motor}_encoder" for motor in drive.motors}
    encoders = [{"kind": "encoder", "name": name, "counts_per_turn": 960} for name in names.values()]
    values = description.model_dump()
    sides = {"left_encoder": drive.left_motors, "right_encoder": drive.right_motors}
    values["drive"] |= {side: [names[motor] for motor in motors] for side, motors in sides.items()}
    return RobotDescription.model_validate({**values, "devices": [*values["devices"], *encoders]})


def _measure_case(seeds: range, seconds: float, case: Case) -> tuple[tuple[str, ...], float]:
    """Return a row of the table, and the ratio of the errors."""
    rate_hz = load_backend(case.backend).encoder_rate_hz
    slow, fast = ([_measure_run(case, seed, seconds, rate) for seed in seeds] for rate in (None, rate_hz))
    before, after = (_compute_rms([each.distance for each in errors]) for errors in (slow, fast))
    headings = [_compute_rms([each.heading for each in errors]) for errors in (slow, fast)]
    row = (
        case.backend,
        case.robot,
        case.motors,
        f"{case.rate_hz:g} Hz",
        f"{1e3 * before:.2f} mm",
        f"{1e3 * after:.2f} mm",
        f"{before / after:.1f}{'' if case.has_bound else ' (no bound)'}",
        " and ".join(f"{1e3 * heading:.1f} mrad" for heading in headings),
    )
    return row, before / after


def _measure_run(case: Case, seed: int, seconds: float, encoder_rate_hz: float | None) -> Errors:
    description = case.describe()
    setup = Setup(description, FIELD, needed_devices(description, [Role.DRIVE]), case.rate_hz, seed)
    fastest = min(each.max_velocity_rad_s for each in description.all_of("motor"))
    with ExitStack() as stack:
        if case.motors == QUICK and case.backend in ENGINES:
            stack.enter_context(patch("robotcore.hal.clock.MIN_PHYSICS_RATE_HZ", FINE_STEPS_HZ))
        raw = stack.enter_context(load_backend(case.backend).open(setup))
        robot = assemble(raw, description, case.rate_hz, encoder_rate_hz=encoder_rate_hz)
        Loop(robot, BangBang(seed, fastest, seconds), case.rate_hz, math.inf).run()
        assert raw.truth, f"{case.backend} does not provide the true pose"
        true, start, pose = raw.truth.pose(), FIELD.start.pose, robot.robot.drive.pose
        heading = wrap_angle(pose.heading - (true.heading - start.heading))
        return Errors(pose.distance_to(*start.to_local(true.x, true.y)), abs(heading))


def _compute_rms(values: list[float]) -> float:
    return math.sqrt(sum(value**2 for value in values) / len(values))


def _measure_cost(seconds: float) -> float:
    """Return the ratio of the times of a tick of green-search with and without polls.

    Their difference is that of an app that does almost nothing. A search has more noise.
    """
    case = Case("kinematic", "rover", LIMITED, 20.0)
    times = []
    for encoder_rate_hz in (KinematicBackend.encoder_rate_hz, None):
        begun = process_time()
        _measure_run(case, 1, seconds, encoder_rate_hz)
        times.append((process_time() - begun) / (case.rate_hz * seconds))
    begun = process_time()
    result = run(RunRequest("green-search", seed=3, timeout_s=seconds))
    search = (process_time() - begun) / result.ticks
    return search / (search - times[0] + times[1])


def _measure_growth(app: str, seconds: float) -> float:
    """Return the size of a recording for each tick, divided by that of a recording without polls."""
    sizes = []
    for encoder_rate_hz in (KinematicBackend.encoder_rate_hz, None):
        with TemporaryDirectory() as folder, patch.object(KinematicBackend, "encoder_rate_hz", encoder_rate_hz):
            recorder = Recorder(Path(folder) / "run.mcap")
            run(RunRequest(app, seed=3, timeout_s=seconds), [recorder], [recorder.layer])
            sizes.append(recorder.path.stat().st_size / len(read(recorder.path).ticks))
    return sizes[0] / sizes[1]


if __name__ == "__main__":
    sys.exit(main())
