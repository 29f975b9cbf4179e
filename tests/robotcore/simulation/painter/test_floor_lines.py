"""Lines on the floor in the pictures of cameras."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.description import Floor, Light, Line, Mount, Texture, WorldDescription
from robotcore.geometry import Pose
from robotcore.optics import CameraView, Intrinsics
from robotcore.simulation.painter import Painter
from tests.robotcore.description.worlds import box
from tests.robotcore.simulation.painter.tracer import compute_rays

LENS = Intrinsics(320, 240, 1.0821)
BENT = Line(width_m=0.1, points_m=((-0.5, -0.3), (0.6, 0.0), (0.5, 0.7)), closed=True)
BRIGHT = Light(ambient=1.0, diffuse=0.0, brightness=1.0)


def build_world(*lines: Line, texture: Texture | None = None, **keys: object) -> WorldDescription:
    floor = Floor(length_m=4, width_m=4, colour=(200, 200, 200), texture=texture)
    return WorldDescription.model_validate({"name": "lined", "floor": floor, "lines": lines, "light": BRIGHT, **keys})


def compute_line_distances(line: Line, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the distance of points to the polyline of a line, in metres."""
    distances = []
    for (ax, ay), (bx, by) in line.segments:
        length = math.dist((ax, ay), (bx, by))
        along = np.clip(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length**2, 0.0, 1.0)
        distances.append(np.hypot(x - ax - along * (bx - ax), y - ay - along * (by - ay)))
    return np.asarray(np.minimum.reduce(distances))


@pytest.mark.parametrize("texture", [None, Texture(pattern="checker")])
@pytest.mark.parametrize(
    "pose, z, pitch", [(Pose(-1.5, 0.2, 0.0), 0.4, 0.3), (Pose(0.0, 0.1, 2.0), 0.2, 0.9), (Pose(0.1, 0, 0), 1.5, 1.5)]
)
def test_each_pixel_shows_the_line_if_its_ray_meets_it(
    texture: Texture | None, pose: Pose, z: float, pitch: float
) -> None:
    view = CameraView.of(LENS, Mount(z_m=z, pitch_rad=pitch), pose)
    is_dark = Painter(build_world(BENT, texture=texture)).picture(view).max(axis=2) == 25
    rays = compute_rays(view)
    is_ground = rays[..., 2] < -1e-6
    x, y = (view.eye[axis] - rays[..., axis] * view.eye[2] / np.where(is_ground, rays[..., 2], -1) for axis in (0, 1))
    distances = compute_line_distances(BENT, x, y)
    half, tolerance = BENT.width_m / 2, 0.001
    assert is_dark[is_ground & (distances < half - tolerance)].all()
    assert not is_dark[~is_ground | (distances > half + tolerance)].any()
    assert is_dark.any()


def test_obstacle_hides_a_line_behind_it() -> None:
    view = CameraView.of(LENS, Mount(z_m=0.1), Pose(-1.5, 0.0, 0.0))
    line = Line(width_m=0.1, points_m=((1.0, -0.1), (1.0, 0.1)))
    free, hidden = build_world(line), build_world(line, obstacles=(box(x_m=0.0),))
    assert (Painter(free).picture(view) == 25).any()
    assert not (Painter(hidden).picture(view) == 25).any()


def test_later_line_covers_an_earlier_one_and_has_no_label() -> None:
    view = CameraView.of(LENS, Mount(z_m=1.0, pitch_rad=1.5), Pose(0.0, 0.0, 0.0))
    points = ((-0.5, 0.0), (0.5, 0.0))
    world = build_world(
        Line(width_m=0.1, points_m=points, colour=(255, 0, 0)), Line(width_m=0.1, points_m=points, colour=(0, 0, 255))
    )
    painter = Painter(world)
    blue, green, red = np.moveaxis(painter.picture(view), 2, 0)
    assert ((blue == 255) & (green == 0)).any()
    assert not ((red == 255) & (green == 0)).any()
    assert not painter.labels(view).any()
