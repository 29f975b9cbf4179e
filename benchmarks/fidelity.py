"""Measure how much simulations differ from robots whose files are wrong, and after the calibration of their files.

    python -m benchmarks.fidelity --robots 10 --simulators kinematic,mujoco --seed 1
    python -m benchmarks.fidelity --robots 4 --simulators mujoco --torque 1.0

Each robot is a simulated rover on `virtualpi`. Its motors, lags, track and wheels differ from the shipped rover by
errors that a seed draws. The shipped file is its user's file. The robot drives a winding way of 5 m, and
`robotcore calibrate` then corrects the user's file. The path error is the largest distance between the robot and its
simulation that repeats the commands. It is measured in three ways:

- before: the recorded drive, simulated with the wrong file;
- after: the same recording, simulated with the corrected file;
- again: a new drive with the corrected file, simulated with that file.

The exit status is 1 if the median of the ratios before / after or before / again is less than `GOAL`.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

import robotcore.description
from benchmarks.report import parse_options, print_table
from benchmarks.winding_drive import WindingDrive
from robotcore import Outcome, RunRequest, run
from robotcore.description import load_robot
from robotcore.fidelity.fidelity import measure_fidelity
from robotcore.recording import Recording, read
from robotcore.recording.recorder import Recorder
from robotcore.sweep.engine import count_cores

GOAL = 5.0
ROVER = Path(robotcore.description.__file__).parent / "robots" / "rover.toml"
PARTS = ("motors", "drive")
"""The parts of the robot that `robotcore calibrate` measures, in their order."""
MODEL = "model = { dead_band = 0.10, forward_rad_s = 14.0, backward_rad_s = 14.0 }"
WORLD = """name = "hall"

[floor]
length_m = 20.0
width_m = 20.0
"""


class Errors(NamedTuple):
    """The largest distances between a robot and its simulations, in metres."""

    before: float
    after: float
    again: float


def main() -> int:
    """Measure all robots on all cores, and print the results."""
    options = parse_options(__doc__, robots=10, simulators="kinematic,mujoco", seed=1, torque=0.08)
    rows, is_missed = [], False
    for simulator in options.simulators.split(","):
        seeds = [f"{options.seed}/{number}" for number in range(options.robots)]
        with ProcessPoolExecutor(count_cores()) as pool:
            errors = list(pool.map(partial(measure_robot, simulator, options.torque), seeds))
        before = [each.before for each in errors]
        rows.append((simulator, "before", *_build_cells(before), "", ""))
        for name in ("after", "again"):
            values = [getattr(each, name) for each in errors]
            ratios = [first / max(value, 1e-6) for first, value in zip(before, values, strict=True)]
            rows.append((simulator, name, *_build_cells(values), f"{median(ratios):.0f}", f"{min(ratios):.1f}"))
            is_missed |= median(ratios) < GOAL
    columns = ("simulator", "path error", "median, m", "largest, m", "times smaller, median", "least")
    print_table(columns, rows)
    return int(is_missed)


def _build_cells(values: Iterable[float]) -> tuple[str, str]:
    found = list(values)
    return f"{median(found):.3f}", f"{max(found):.3f}"


def measure_robot(simulator: str, torque_nm: float, seed: str) -> Errors:
    """Record a drive of a robot, correct its file, and record another drive.

    torque_nm: the greatest torque of the motors, in N·m. The simulator kinematic has no torques.
    """
    with TemporaryDirectory() as folder:
        truth, own, world = (Path(folder, name) for name in ("true.toml", "my_robot.toml", "hall.toml"))
        truth.write_text(draw_truth(read_rover(torque_nm), Random(seed)), encoding="utf-8")
        own.write_text(read_rover(torque_nm), encoding="utf-8")
        world.write_text(WORLD, encoding="utf-8")
        options = {"truth": str(truth), "simulator": simulator}
        first = record_drive(Path(folder, "first.mcap"), own, world, options)
        calibrate(own, world, options)
        found = measure_fidelity(first, "first.mcap", simulator, robot=load_robot(str(own)))
        second = record_drive(Path(folder, "second.mcap"), own, world, options)
        again = measure_fidelity(second, "second.mcap", simulator)
    return Errors(
        *(each.differences.path.largest_m for each in (*found.simulations, *again.simulations) if each.differences.path)
    )


def read_rover(torque_nm: float) -> str:
    """Return the file of the shipped rover, with a body that is wide enough for each track that is drawn."""
    text = ROVER.read_text(encoding="utf-8").replace("width_m = 0.185", "width_m = 0.195")
    return text.replace("max_torque_nm = 0.08", f"max_torque_nm = {torque_nm}")


def draw_truth(text: str, draw: Random) -> str:
    """Return the file of a rover with errors of its motors, its track and its wheels.

    text: the file of the rover without the errors.
    """
    for _ in range(2):
        band, forward, backward = draw.uniform(0.05, 0.18), draw.uniform(12.6, 15.4), draw.uniform(12.6, 15.4)
        model = f"{{ dead_band = {band:.4f}, forward_rad_s = {forward:.3f}, backward_rad_s = {backward:.3f} }}"
        text = text.replace(MODEL, f"model = {model}", 1)
        text = text.replace("lag_s = 0.05\n", f"lag_s = {draw.uniform(0.03, 0.1):.4f}\n", 1)
    text = text.replace("track_m = 0.155", f"track_m = {0.155 * draw.uniform(0.97, 1.03):.5f}")
    return text.replace("wheel_radius_m = 0.0325", f"wheel_radius_m = {0.0325 * draw.uniform(0.97, 1.03):.5f}")


def record_drive(file: Path, robot: Path, world: Path, options: dict[str, str]) -> Recording:
    """Record a drive of a robot with its user's file."""
    recorder = Recorder(file)
    request = RunRequest(WindingDrive, "virtualpi", str(robot), str(world), options=options)
    result = run(request, [recorder], [recorder.layer])
    if result.outcome is not Outcome.SUCCESS:
        raise SystemExit(f"the drive ended with {result.headline}: {result.reason}")
    return read(file)


def calibrate(robot: Path, world: Path, options: dict[str, str]) -> None:
    """Correct the file of a robot by the commands of `robotcore calibrate`."""
    choice = [f"--option={key}={value}" for key, value in options.items()]
    for part in PARTS:
        command = [sys.executable, "-m", "robotcore", "calibrate", part, "--robot", str(robot), "--write"]
        place = ["--backend", "virtualpi", "--world", str(world)]
        subprocess.run([*command, *place, *choice], input="\n" * 9, text=True, check=True, capture_output=True)  # noqa: S603  our own


if __name__ == "__main__":
    sys.exit(main())
