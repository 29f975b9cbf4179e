"""Calibrate the drive of robots whose wheel radius and track are wrong, and compare the files with the truth.

    python -m benchmarks.calibration_drive --robots 8 --seed 1

Each robot is a rover on virtualpi. Its true wheel radius and its true track differ by up to 8 % from its file. Its
motors have different lags, from 20 ms to 150 ms, which its file has. The references are a tape measure with errors of
2 mm and 1°, an IMU with noise and drift, and the walls of a room by an ultrasonic sensor. The table has the greatest
errors. The wheels have one radius, so the error of the ratio is the part of the lags in it. The exit status is 1 if an
error by the tape or the IMU exceeds 0.5 %, an error by the walls 1 %, or an error of the ratio twice its uncertainty.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from benchmarks.calibration_robots import IMU, MOTORS, WORLD, InaccurateTape, NoPerson, patient_run
from benchmarks.report import parse_options, print_table
from robotcore.calibration.calibrated_robot import CalibratedRobot
from robotcore.calibration.drive.measurement import Reference, measure_drive
from robotcore.calibration.least_squares import Estimate
from robotcore.description import read_shipped
from robotcore.description.editing import RobotEditor
from robotcore.hal.backend import load_backend
from robotcore.sweep.engine import count_cores

ROOM = """
name = "room"
[floor]
length_m = 3.0
width_m = 3.6
[walls]
height_m = 0.4
[start]
x_m = -0.4
y_m = 0.6
[[obstacles]]
name = "box"
shape = "box"
x_m = -0.6
y_m = -0.9
length_m = 0.4
width_m = 0.3
height_m = 0.3
colour = "grey"
"""

CASES = {
    "tape": (Reference.TAPE, Reference.TAPE, 2.0, 0.005),
    "imu": (Reference.TAPE, Reference.IMU, 2.0, 0.005),
    "wall": (Reference.WALL, Reference.WALL, 1.0, 0.01),
}
"""For each reference that of the straight drives and of the turns, the distance in metres, and the greatest error."""

SPREAD = 0.08
LAGS_S = 0.02, 0.15
TURNS = 5


def main() -> int:
    """Calibrate, and print the greatest errors."""
    options = parse_options(__doc__, robots=8, seed=1)
    seeds = range(options.seed, options.seed + options.robots)
    rows, is_missed = [], False
    with ProcessPoolExecutor(count_cores()) as pool:
        for name, (_, _, _, goal) in CASES.items():
            errors = list(pool.map(partial(measure_errors, name), seeds))
            worst = [max(abs(each[index]) for each in errors) for index in (0, 1, 2)]
            is_missed |= max(worst[:2]) > goal or any(abs(ratio) > 2 * deviation for *_, ratio, deviation in errors)
            shown = worst[: 3 if errors[0][3] else 2]
            rows.append([name, f"{len(errors)}", *(f"{100 * each:.2f} %" for each in shown), *[""] * (3 - len(shown))])
    print_table(["greatest error by", "robots", "wheel radius", "track", "ratio of the wheels' radii"], rows)
    return int(is_missed)


def measure_errors(case: str, seed: int) -> tuple[float, float, float, float]:
    """Calibrate the robot of a seed; return the errors of its radius, its track and the ratio of its wheels' radii.

    The errors are shares of the true values. The last number is the deviation of the ratio; a wall gives no ratio, and
    both numbers are 0.
    """
    straight_by, turns_by, distance_m, _ = CASES[case]
    draw = Random(seed)
    radius, track = (value * draw.uniform(1 - SPREAD, 1 + SPREAD) for value in (0.0325, 0.155))
    lags = [draw.uniform(*LAGS_S) for _ in MOTORS]
    with TemporaryDirectory() as folder:
        own, truth, room = (str(file) for file in _write_files(Path(folder), radius, track, lags))
        robot = CalibratedRobot.load(own, load_backend("virtualpi"), {"truth": truth})
        world = room if Reference.WALL in (straight_by, turns_by) else WORLD
        runner = InaccurateTape(robot, patient_run, NoPerson(), world)
        runner.draw = Random(seed)
        result = measure_drive(runner, straight_by, turns_by, distance_m, TURNS)
    assert result.track
    ratio = result.ratio or Estimate(1.0, 0.0)
    return result.radius.value / radius - 1, result.track.value / track - 1, ratio.value - 1, ratio.deviation


def _write_files(folder: Path, radius: float, track: float, lags: Sequence[float]) -> Iterator[Path]:
    text = read_shipped("rover").replace("width_m = 0.185", "width_m = 0.21")  # room for a wider track
    for name, noise in (("own", 0.0), ("truth", 0.005)):
        file = folder / f"{name}.toml"
        file.write_text(text + IMU.format(noise=noise, bias=4 * noise), encoding="utf-8")
        editor = RobotEditor(str(file))
        for motor, lag in zip(MOTORS, lags, strict=True):
            editor.set_device(motor, lag_s=round(lag, 4))
        if noise:
            editor.set_drive(wheel_radius_m=radius, track_m=track)
        editor.write()
        yield file
    (folder / "room.toml").write_text(ROOM, encoding="utf-8")
    yield folder / "room.toml"


if __name__ == "__main__":
    sys.exit(main())
