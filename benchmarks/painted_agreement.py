"""Measure whether painted cameras show the ball as the engines' renderers do.

    python -m benchmarks.painted_agreement

In each world, a rover stands at random free poses near which the ball is in view. Its body rolls and pitches a little.
The masks of the ball in the painted and in the rendered picture agree if their centroids are at most 1 px apart, and
their areas differ by at most 3 %.

An engine draws the ball as a mesh of triangles. So the rays of all pixels are traced too. The painted mask must have
exactly the pixels whose rays meet the ball. The rendered mask must have the pixels whose rays meet the engine's mesh,
except for a few at its edge, because an engine rounds the corners. Then the mesh alone explains masks that do not
agree. The exit status is 1 if one of the two bounds is broken.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from random import Random
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.report import parse_options, print_table
from drivers.kinematic.clearance import Clearance
from drivers.mujoco.model.world import BALL_SLICES, BALL_STACKS
from robotcore.description import (
    Ball,
    RobotDescription,
    WorldDescription,
    draw_world,
    load_robot,
    load_world,
    randomise,
)
from robotcore.description.meshes import ball_mesh
from robotcore.geometry import Pose
from robotcore.hal.backend import Setup, load_backend
from robotcore.kinds.camera import CameraDescription
from robotcore.optics import CameraView
from robotcore.simulation.painter import Painter
from robotcore.simulation.rigid_body import BodyCamera
from tests.robotcore.simulation.painter.tracer import compute_rays, roll, trace_depths

WORLDS = ("arena", "clutter", "occluded", "open")
POSES_A_WORLD, MAX_DRAWS = 10, 400
MIN_PIXELS = 200
TILT_RAD, ASIDE_RAD = 0.05, 0.6
"""The greatest roll and pitch of the body, and the greatest angle between the camera and the ball."""

MAX_OFF_PX, MAX_AREA = 1.0, 0.03
MAX_ROUNDED = 3
"""The greatest number of pixels in which a rendered ball may differ from its mesh."""

Mask = NDArray[np.bool_]


class Comparison(NamedTuple):
    """The comparison of a painted and a rendered picture."""

    off_px: float
    """The distance between the centroids of the masks."""
    area: float
    """The difference between their areas, relative to the area of the rendered mask."""
    from_ball: int
    """The number of pixels in which the painted mask differs from the traced ball."""
    from_mesh: int
    """The number of pixels in which the rendered mask differs from the traced mesh."""


def main() -> int:
    """Compare the masks for each engine, in plain and in randomised worlds."""
    options = parse_options(__doc__, poses=150, seed=1, backends="pybullet,mujoco")
    rows, is_met = [], True
    for backend in options.backends.split(","):
        for is_randomised in (False, True):
            found = list(_compare_all(backend, options.poses, options.seed, is_randomised=is_randomised))
            off, area, from_ball, from_mesh = map(max, zip(*found, strict=True))
            agreeing = sum(each.off_px <= MAX_OFF_PX and each.area <= MAX_AREA for each in found)
            worlds = "randomised" if is_randomised else "plain"
            differences = f"{off:.2f}", f"{100 * area:.1f}", str(from_ball), str(from_mesh)
            rows.append((backend, worlds, f"{agreeing}/{len(found)}", *differences))
            is_met &= from_ball == 0 and from_mesh <= MAX_ROUNDED
    traced = "painted, off the ball, px, = 0", f"rendered, off its mesh, px, ≤ {MAX_ROUNDED}"
    print_table(("backend", "worlds", "agree", "farthest centroid, px", "greatest area, %", *traced), rows)
    return int(not is_met)


def _compare_all(backend: str, poses: int, seed: int, *, is_randomised: bool) -> Iterator[Comparison]:
    robot, draw = load_robot("rover"), Random(f"{backend} {is_randomised} {seed}")
    number = 0
    while poses > 0:
        drawn = draw.randrange(1_000_000)
        world = draw_world(load_world(WORLDS[number % len(WORLDS)]), robot, drawn)
        if is_randomised:
            world = randomise(world, drawn).world
        compared = list(_compare_in_world(backend, robot, world, draw, min(poses, POSES_A_WORLD)))
        yield from compared
        poses, number = poses - len(compared), number + 1


def _compare_in_world(
    backend: str, robot: RobotDescription, world: WorldDescription, draw: Random, poses: int
) -> Iterator[Comparison]:
    painter, (ball,) = Painter(world), world.targets
    label = painter.things.index(ball.name) + 1
    with load_backend(backend).open(Setup(robot, world, frozenset({"eye"}))) as opened:
        camera = opened.camera
        assert isinstance(camera, BodyCamera)
        for view in _draw_views(robot, world, draw):
            painted = painter.labels(view) == label
            if painted.sum() >= MIN_PIXELS:
                rendered = camera.segmentation(view) == camera.things[ball.name]
                yield _compare(painted, rendered, backend, world, view)
                poses -= 1
            if not poses:
                return


def _draw_views(robot: RobotDescription, world: WorldDescription, draw: Random) -> Iterator[CameraView]:
    """Yield the views of the robot's camera at random free poses, roughly towards the ball."""
    surroundings, eye, (ball,) = (
        Clearance(robot.body.footprint, world),
        robot.first_of(CameraDescription),
        world.targets,
    )
    assert eye, "the robot has a camera"
    x, y = world.floor.length_m / 2, world.floor.width_m / 2
    for _ in range(MAX_DRAWS):
        place = Pose(draw.uniform(-x, x), draw.uniform(-y, y), 0.0)
        heading = place.bearing_to(ball.x_m, ball.y_m) + draw.uniform(-ASIDE_RAD, ASIDE_RAD)
        pitch, angle = (draw.uniform(-TILT_RAD, TILT_RAD) for _ in range(2))
        if surroundings.measure_gaps(place._replace(heading=heading)).min() > 0:
            mount = eye.mount.model_copy(update={"pitch_rad": eye.mount.pitch_rad + pitch})
            yield roll(CameraView.of(eye.intrinsics, mount, place._replace(heading=heading)), angle)


def _compare(painted: Mask, rendered: Mask, backend: str, world: WorldDescription, view: CameraView) -> Comparison:
    exact, meshed = _trace_ball(world, view, _list_vertices(backend, world.targets[0]))
    from_ball, from_mesh = int((painted ^ exact).sum()), int((rendered ^ meshed).sum())
    area = int(rendered.sum())
    if not area:
        return Comparison(math.inf, math.inf, from_ball, from_mesh)
    off = math.dist(_find_centroid(painted), _find_centroid(rendered))
    return Comparison(off, abs(int(painted.sum()) - area) / area, from_ball, from_mesh)


def _find_centroid(mask: Mask) -> tuple[float, float]:
    rows, columns = np.nonzero(mask)
    return float(columns.mean()), float(rows.mean())


def _list_vertices(backend: str, ball: Ball) -> NDArray[np.float64]:
    """Return the vertices of the mesh that an engine draws as the ball, (n, 3)."""
    middle = np.array((ball.x_m, ball.y_m, ball.radius_m))
    if backend == "pybullet":
        return np.asarray(middle + ball_mesh(ball.radius_m).vertices)
    polar = np.linspace(0, math.pi, BALL_STACKS + 1)[:, None]
    around = np.linspace(0, math.tau, BALL_SLICES + 1)[None, :]
    z = np.broadcast_to(np.cos(polar), (BALL_STACKS + 1, BALL_SLICES + 1))
    points = np.stack((np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), z), axis=-1).reshape(-1, 3)
    return np.asarray(middle + ball.radius_m * points)


def _trace_ball(world: WorldDescription, view: CameraView, vertices: NDArray[np.float64]) -> tuple[Mask, Mask]:
    """Return the pixels whose rays meet the ball first, and those whose rays meet its mesh first."""
    rays, depths = compute_rays(view), trace_depths(world, view)
    exact = depths.argmin(axis=0) == len(depths) - 1
    floor = np.where(rays[..., 2] < 0, -view.eye[2] / np.minimum(rays[..., 2], -1e-12), np.inf)
    others = np.minimum(depths[:-1].min(axis=0), floor)
    ball = world.targets[0]
    to_ball = np.array((ball.x_m, ball.y_m, ball.radius_m)) - view.eye
    # Other bodies do not overlap the ball, so a body is before or behind the nearest point to the ball's centre.
    is_free = rays @ to_ball / (rays * rays).sum(axis=2) < others
    return exact, _is_in_outline(view, vertices) & is_free


def _is_in_outline(view: CameraView, vertices: NDArray[np.float64]) -> Mask:
    """Return for each pixel whether it is in the outline of a convex mesh."""
    corners = cv2.convexHull(view.to_pixels(view.to_camera(vertices)).astype(np.float32))[:, 0].astype(np.float64)
    i = view.intrinsics
    u, v = np.meshgrid(np.arange(i.width), np.arange(i.height))
    is_inside = np.ones(u.shape, dtype=bool)
    turn = 1.0 if cv2.contourArea(corners.astype(np.float32), oriented=True) > 0 else -1.0
    for (x, y), (next_x, next_y) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        is_inside &= turn * ((next_x - x) * (v - y) - (next_y - y) * (u - x)) >= 0
    return is_inside


if __name__ == "__main__":
    sys.exit(main())
