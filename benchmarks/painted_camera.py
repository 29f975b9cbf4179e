"""Compare the kinematic backend's painted camera with a physics engine's renderer, in content and speed.

    python -m benchmarks.painted_camera --seed 0 --worlds arena,clutter
    python -m benchmarks.painted_camera --randomise
    python -m benchmarks.painted_camera --backend mujoco

Both cameras render the same random poses in random worlds, and take turns in going first. A pose counts if the engine
shows at least 200 pixels of the ball. The benchmark compares the position and the area of the ball, and the mean colour
of every object. The exit status is 1 if a bound is broken. The ratio of speeds has a bound against PyBullet only.
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import sys
from collections.abc import Callable, Iterable, Iterator
from itertools import count, islice
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import at_least_one, machine, print_table
from drivers.kinematic.clearance import Clearance
from drivers.mujoco.devices import MujocoCamera
from drivers.pybullet.sensors import BulletCamera
from robotcore.description import (
    Ball,
    CameraDescription,
    RobotDescription,
    WorldDescription,
    draw_world,
    load_robot,
    load_world,
    randomise,
)
from robotcore.geometry import Pose
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.devices import Image
from robotcore.optics import CameraView
from robotcore.simulation.painter import Painter

MIN_PIXELS = 200
MAX_SHIFT_PX, MAX_AREA, MAX_COLOUR = 1.0, 0.03, 3.0
MIN_SPEED_UP, MIN_SPEED_UP_TEXTURED = 8.0, 3.0
ENGINES = ("pybullet", "mujoco")
POSES_A_WORLD = 10

Mask = NDArray[np.bool_]
EngineCamera = BulletCamera | MujocoCamera


class Comparison(NamedTuple):
    """The comparison of one view: shift and area of the ball, mean colours, and the time of each camera."""

    shift_px: float
    area: float
    colour: float
    engine_s: float
    painter_s: float

    @property
    def is_within(self) -> bool:
        return self.shift_px <= MAX_SHIFT_PX and abs(self.area) <= MAX_AREA and self.colour <= MAX_COLOUR


def main() -> None:
    """Compare the cameras, and print a row for each world."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--backend", default="pybullet", choices=ENGINES)
    parser.add_argument("--worlds", default="arena,clutter")
    parser.add_argument("--poses", type=at_least_one, default=100, help="the number of poses for each world")
    parser.add_argument("--randomise", action="store_true", help="with random light, colours and textures")
    options = parser.parse_args()
    print(machine())
    results = {
        world: list(
            islice(_compare_worlds(options.backend, world, options.seed, is_random=options.randomise), options.poses)
        )
        for world in options.worlds.split(",")
    }
    columns = (
        "world",
        "within 1 px, 3 %, 3 levels",
        "largest shift, px",
        "largest area, %",
        "largest colour, levels",
        f"{options.backend}, ms",
        "painted, ms",
        "ratio",
    )
    print_table(columns, [_build_row(world, compared) for world, compared in results.items()])
    is_kept = all(one.is_within for compared in results.values() for one in compared)
    ratio = MIN_SPEED_UP_TEXTURED if options.randomise else MIN_SPEED_UP
    is_fast = options.backend != "pybullet" or all(
        _compute_speed_up(compared) >= ratio for compared in results.values()
    )
    sys.exit(not (is_kept and is_fast))


def _compare_worlds(backend: str, world: str, seed: int, *, is_random: bool) -> Iterator[Comparison]:
    robot = load_robot("rover")
    for number in count():
        drawn = draw_world(load_world(world), robot, 1000 * seed + number)
        drawn = randomise(drawn, 1000 * seed + number).world if is_random else drawn
        draw = random.Random(f"{seed}/{number}")
        yield from islice(_compare_in_world(backend, drawn, robot, draw), POSES_A_WORLD)


def _compare_in_world(
    backend: str, world: WorldDescription, robot: RobotDescription, draw: random.Random
) -> Iterator[Comparison]:
    eye = robot.first_of(CameraDescription)
    assert eye, "the robot has a camera"
    painter, surroundings = Painter(world), Clearance(robot.body.footprint, world)
    with load_backend(backend).open(Setup(robot, world, frozenset({eye.name}))) as opened:
        camera = opened.camera
        assert isinstance(camera, EngineCamera)
        while True:
            pose = _draw_pose(world, draw)
            if surroundings.measure_gaps(pose).min() < 0:
                continue
            view = CameraView.of(eye.intrinsics, eye.mount, pose)
            masks = _compute_masks(camera, painter, view)
            expected, got = masks[_get_ball(world).name]
            if expected.sum() >= MIN_PIXELS:
                colour = _compute_colour_difference(camera.picture(view), painter.picture(view), masks.values())
                yield Comparison(*_compute_difference(expected, got), colour, *_time_both(camera, painter, view, draw))


def _get_ball(world: WorldDescription) -> Ball:
    assert world.target, "the world has a ball"
    return world.target


def _draw_pose(world: WorldDescription, draw: random.Random) -> Pose:
    half_length, half_width = world.floor.length_m / 2, world.floor.width_m / 2
    place = Pose(draw.uniform(-half_length, half_length), draw.uniform(-half_width, half_width), 0.0)
    ball = _get_ball(world)
    return place._replace(heading=place.bearing_to(ball.x_m, ball.y_m) + draw.uniform(-0.7, 0.7))


def _compute_masks(camera: EngineCamera, painter: Painter, view: CameraView) -> dict[str, tuple[Mask, Mask]]:
    numbers, labels = camera.segmentation(view), painter.labels(view)
    return {
        thing: (numbers == camera.things[thing], labels == label) for label, thing in enumerate(painter.things, start=1)
    }


def _compute_colour_difference(expected: Image, got: Image, masks: Iterable[tuple[Mask, Mask]]) -> float:
    """Return the largest difference between the mean colours of an object in both pictures, in grey levels."""
    return max(
        float(np.abs(expected[theirs].mean(axis=0) - got[ours].mean(axis=0)).max())
        for theirs, ours in masks
        if min(theirs.sum(), ours.sum()) >= MIN_PIXELS
    )


def _compute_difference(expected: Mask, got: Mask) -> tuple[float, float]:
    """Return the distance of the masks' centroids, in pixels, and the relative difference of their areas."""
    if not got.any():
        return math.inf, -1.0
    centres = [np.argwhere(mask).mean(axis=0) for mask in (expected, got)]
    return float(np.linalg.norm(centres[1] - centres[0])), float(got.sum() / expected.sum() - 1)


def _time_both(camera: EngineCamera, painter: Painter, view: CameraView, draw: random.Random) -> tuple[float, float]:
    """Return the seconds that each camera takes for a view. A random camera goes first."""
    if draw.random() < 0.5:
        engine = _time_picture(camera.picture, view)
        return engine, _time_picture(painter.picture, view)
    painted = _time_picture(painter.picture, view)
    return _time_picture(camera.picture, view), painted


def _time_picture(picture: Callable[[CameraView], object], view: CameraView) -> float:
    start = perf_counter()
    picture(view)
    return perf_counter() - start


def _compute_speed_up(compared: list[Comparison]) -> float:
    return statistics.median(one.engine_s / one.painter_s for one in compared)


def _build_row(world: str, compared: list[Comparison]) -> list[str]:
    return [
        world,
        f"{sum(one.is_within for one in compared)}/{len(compared)}",
        f"{max(one.shift_px for one in compared):.2f}",
        f"{100 * max(abs(one.area) for one in compared):.2f}",
        f"{max(one.colour for one in compared):.2f}",
        f"{1000 * statistics.median(one.engine_s for one in compared):.2f}",
        f"{1000 * statistics.median(one.painter_s for one in compared):.2f}",
        f"{_compute_speed_up(compared):.1f}",
    ]


if __name__ == "__main__":
    main()
