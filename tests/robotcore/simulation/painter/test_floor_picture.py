"""The picture on the floor in the pictures of cameras."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robotcore.description import Light, Mount, WorldDescription
from robotcore.description.floor_colours import FloorColours
from robotcore.geometry import Pose
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.painter import Painter
from tests.robotcore.description.courses import COURSE, load_course
from tests.robotcore.description.worlds import box
from tests.robotcore.simulation.painter.tracer import compute_rays, roll

LENS = Intrinsics(320, 240, 1.0821)
NOISE = np.random.default_rng(1).integers(0, 256, (40, 60, 3), np.uint8)
LINE = "[[lines]]\nwidth_m = 0.1\npoints_m = [[-1.0, 0.0], [1.0, 0.0]]\n"
PATTERN = COURSE.replace("colour =", 'texture = { pattern = "checker", scale_m = 1.0, contrast = 0.5 }\ncolour =')


def find_differences(world: WorldDescription, view: CameraView, picture: Image) -> np.ndarray:
    """Return by how much each pixel near the camera differs from the floor's colour on its ray, (n,).

    On a floor with a pattern, only the pixels of the picture count, because the painter fades a pattern.
    """
    rays = compute_rays(view)
    is_near = rays[..., 2] < -0.1
    points = view.eye + rays[is_near] * (-view.eye[2] / rays[is_near][:, 2:])
    brightness = min(world.light.ambient + world.light.diffuse * world.light.direction[2], 1.0)
    colours = np.minimum(FloorColours(world).measure(points[:, :2]) * brightness * world.light.brightness, 255.0)
    differences = np.abs(colours[:, ::-1] - picture[is_near]).max(axis=1)
    assert world.floor.image
    return np.asarray(differences[world.floor.image.locate(points[:, :2])[0]] if world.floor.texture else differences)


@pytest.mark.parametrize("text", [COURSE, COURSE + LINE, PATTERN], ids=["picture", "line", "pattern"])
@pytest.mark.parametrize(
    "pose, z, pitch",
    [
        (Pose(-1.5, 0.2, 0.0), 0.4, 0.3),
        (Pose(0.5, -0.2, 2.0), 0.2, 0.9),
        (Pose(0.5, -0.3, 0.7), 2.5, 1.5),
        (Pose(1.25, -0.2, -1.0), 0.05, 0.0),
        (Pose(9.0, 9.0, 0.0), 0.3, 0.3),
    ],
    ids=["ahead", "on it", "above", "edge", "away"],
)
@pytest.mark.parametrize("light", [Light(ambient=1.0, diffuse=0.0), Light(ambient=0.2, diffuse=0.9, brightness=1.3)])
def test_each_pixel_has_the_colour_of_the_floor_on_its_ray(
    tmp_path: Path, text: str, pose: Pose, z: float, pitch: float, light: Light
) -> None:
    world = load_course(tmp_path, NOISE, text).model_copy(update={"light": light})
    view = CameraView.of(LENS, Mount(z_m=z, pitch_rad=pitch), pose)
    differences = find_differences(world, view, Painter(world).picture(view))
    assert (differences <= 2).sum() >= 0.999 * len(differences)


@pytest.mark.parametrize("text", [COURSE, COURSE + LINE, PATTERN], ids=["picture", "line", "pattern"])
@pytest.mark.parametrize("angle", [-0.6, 0.02, 1.6])
def test_a_camera_that_rolls_shows_the_floor_on_its_rays(tmp_path: Path, text: str, angle: float) -> None:
    world = load_course(tmp_path, NOISE, text)
    view = roll(CameraView.of(LENS, Mount(z_m=0.3, pitch_rad=0.5), Pose(-0.2, -0.2, 0.3)), angle)
    differences = find_differences(world, view, Painter(world).picture(view))
    assert (differences <= 2).sum() >= 0.999 * len(differences) > 20_000


def test_obstacle_hides_the_picture_and_the_picture_has_no_label(tmp_path: Path) -> None:
    world = load_course(tmp_path, np.full((4, 6, 3), (255, 0, 255), np.uint8))
    view = CameraView.of(LENS, Mount(z_m=0.1), Pose(-1.5, -0.2, 0.0))
    hidden = world.model_copy(update={"obstacles": (box(x_m=-1.0, y_m=-0.2, width_m=2.0, height_m=0.5),)})
    assert ((Painter(world).picture(view) == (255, 0, 255)).all(axis=2)).any()
    assert not ((Painter(hidden).picture(view) == (255, 0, 255)).all(axis=2)).any()
    assert not Painter(world).labels(view).any()


@pytest.mark.parametrize("z, pitch", [(0.1, -1.0), (0.0, 1.0)], ids=["looks up", "at floor"])
def test_camera_that_looks_up_or_lies_on_the_floor_sees_no_picture(tmp_path: Path, z: float, pitch: float) -> None:
    world = load_course(tmp_path, NOISE)
    view = CameraView.of(LENS, Mount(z_m=z, pitch_rad=pitch), Pose(0.5, -0.2, 0.0))
    assert len(np.unique(Painter(world).picture(view).reshape(-1, 3), axis=0)) == 1
