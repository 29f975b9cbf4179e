"""Measure the errors of `robotcore calibrate camera`: of the intrinsics and of the delay.

    python -m benchmarks.calibration_camera

Intrinsics: a seed draws cameras (45° to 80° wide, a lens with distortion, noise of 1 to 6 grey levels, 320x240 and
640x480 pixels), and poses of a chessboard. OpenCV remaps the board into the pictures. The error of all directions is
the greatest difference between the true and the measured direction of a pixel, as a share of half the field of view.
Some pictures come from the project's own simulated cameras: a floor with a board, at other pitches of the camera. They
have no bound: without a roll of the camera, the pictures leave the optical axis uncertain, and their edges have steps.

Delay: the rover turns on a simulator, and its file describes a latency of 20 to 200 ms. The stamps of a simulated
camera are right, and give the delay alone. So the delay is also measured with stamps of the arrival, as of a camera
whose driver does not know the time of the capture: then it follows from the rotation in the pictures alone.

The exit status is 1 if an error exceeds 1 % or 10 ms.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import robotcore
from benchmarks.report import parse_options, print_table
from robotcore.calibration.camera.board import Board
from robotcore.calibration.camera.delay import TimedPicture, TurnRecord, fit_delay
from robotcore.calibration.camera.intrinsics import IntrinsicsFit, collect_views, fit_intrinsics
from robotcore.calibration.camera.measuring import record_turn
from robotcore.description import read_shipped
from robotcore.errors import CalibrationError
from robotcore.hal.robot import Role
from robotcore.optics import Intrinsics
from tests.robotcore.calibration.camera.rendered_boards import draw_camera
from tests.robotcore.calibration.camera.simulated_boards import take_floor_pictures

MAX_SHARE, MAX_DELAY_ERROR_S = 0.01, 0.010
LATENCIES_S = (0.02, 0.05, 0.08, 0.11, 0.15, 0.2)
RATE_HZ = 50.0
BOARD = Board(9, 6, 0.025)


def main() -> int:
    options = parse_options(
        __doc__ or "",
        cameras=40,
        simulated=2,
        seeds=3,
        seed=0,
        worlds="bench arena",
        backends="kinematic mujoco virtualpi",
    )
    errors = [*measure_intrinsics(options.cameras, options.seed)]
    is_good = print_intrinsics("rendered boards", errors)
    print_intrinsics("simulated cameras above a board", [*measure_simulated(options.simulated, options.seed)])
    rows, worst = [], 0.0
    for backend in options.backends.split():
        for world in options.worlds.split():
            found = [
                measure_delay(backend, world, latency, seed)
                for latency in LATENCIES_S
                for seed in range(options.seed, options.seed + options.seeds)
            ]
            by_stamp, by_picture = (max(abs(each[index]) for each in found) for index in (0, 1))
            worst = max(worst, by_stamp, by_picture)
            rows.append((backend, world, str(len(found)), f"{by_stamp * 1e3:.1f}", f"{by_picture * 1e3:.1f}"))
    print()
    columns = ("backend", "world", "runs", "greatest error, ms", "with stamps of the arrival, ms")
    print_table(columns, rows)
    return int(not is_good or worst > MAX_DELAY_ERROR_S)


Errors = tuple[float, float]
"""The error of the focal length, and that of all directions, as shares."""


def measure_intrinsics(count: int, seed: int) -> Iterator[Errors | None]:
    """Yield the errors for cameras that are drawn from a seed; None for a camera whose fit was refused."""
    for number in range(count):
        random_ = random.Random(f"{seed}:{number}")
        size = (640, 480) if number % 2 else (320, 240)
        camera = draw_camera(random_, *size)
        yield _fit(camera.render_views(BOARD, 30, random_), camera.intrinsics)


def measure_simulated(count: int, seed: int) -> Iterator[Errors | None]:
    """Yield the errors for simulated cameras with a described lens and noise, above a floor with a board."""
    for number in range(count):
        pictures, truth, board = take_floor_pictures(random.Random(f"{seed}:{number}"))
        yield _fit(pictures, truth, board)


def _fit(pictures: Iterator[robotcore.optics.Image], truth: Intrinsics, board: Board = BOARD) -> Errors | None:
    try:
        selection, _ = collect_views(pictures, board)
        fit = fit_intrinsics(selection, board)
    except CalibrationError as error:
        print(f"refused: {error}")
        return None
    return abs(fit.focal_length_px / truth.focal_length - 1), _compare_directions(fit, truth)


def _compare_directions(fit: IntrinsicsFit, truth: Intrinsics) -> float:
    width, height = fit.size
    u, v = np.meshgrid(np.linspace(0, width - 1, 17), np.linspace(0, height - 1, 13))
    pixels = np.stack((u.ravel(), v.ravel()), axis=1)
    measured = Intrinsics(width, height, fit.horizontal_fov_rad, fit.centre_px, fit.distortion)
    angles = [
        np.arctan((each.undistort(pixels) - (each.cx, each.cy)) / each.focal_length) for each in (measured, truth)
    ]
    return float(np.abs(angles[0] - angles[1]).max() / (truth.horizontal_fov / 2))


def print_intrinsics(title: str, errors: list[Errors | None]) -> bool:
    """Print a table, and return whether all errors are within the goal."""
    found = [each for each in errors if each]
    print(f"\n{title}: {len(found)} of {len(errors)} fits were accepted")
    if not found:
        return False
    rows = []
    for index, name in enumerate(("focal length", "all directions")):
        values = sorted(each[index] for each in found)
        rows.append((name, f"{values[len(values) // 2]:.3%}", f"{values[-1]:.3%}"))
    print_table(("error of", "median", "greatest"), rows)
    return len(found) == len(errors) and all(max(each) < MAX_SHARE for each in found)


def measure_delay(backend: str, world: str, latency_s: float, seed: int) -> tuple[float, float]:
    """Return the errors of a delay in seconds: with the stamps of the simulator, and with those of the arrival."""
    with TemporaryDirectory() as folder:
        true, user = Path(folder, "true.toml"), Path(folder, "user.toml")
        text = read_shipped("rover")
        key = "horizontal_fov_rad = 1.0821"
        true.write_text(text.replace(key, f"latency_s = {latency_s}\nnoise_levels = 2.0\n{key}"))
        user.write_text(text)
        name, chosen = (user, {"truth": str(true)}) if backend == "virtualpi" else (true, {})
        with robotcore.open(
            str(name),
            backend,
            world=world,
            seed=seed,
            rate_hz=RATE_HZ,
            needs={Role.DRIVE, Role.CAMERA},
            options=chosen,
        ) as robot:
            record: TurnRecord = robot.run(record_turn(robot, robot.camera, RATE_HZ))
            fov = robot.camera.intrinsics.horizontal_fov
    fit = fit_delay(record, fov, 1 / RATE_HZ)
    return fit.latency_s - latency_s, fit_delay(_stamp_arrivals(record), fov, 1 / RATE_HZ).latency_s - latency_s


def _stamp_arrivals(record: TurnRecord) -> TurnRecord:
    """Return the record of a camera whose driver stamps each picture at its arrival."""
    changed, ages = TurnRecord(), dict(zip(record.stamps, record.ages, strict=True))
    changed.headings = record.headings
    changed.pictures = [TimedPicture(each.grey, each.stamp + ages[each.stamp]) for each in record.pictures]
    changed.stamps = [stamp + age for stamp, age in ages.items()]
    changed.ages = [0.0] * len(ages)
    return changed


if __name__ == "__main__":
    sys.exit(main())
