from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from robotcore.description import Light, Mount, Texture, Walls, WorldDescription
from robotcore.description.meshes import Wrap, face_wrap, floor_wrap
from robotcore.description.texture import PATTERNS, TILE_PX
from robotcore.geometry import Pose
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.painter import Painter
from tests.drivers.kinematic.rooms import ball, box, post, room
from tests.robotcore.simulation.painter.tracer import compute_rays, trace_depths, trace_labels

LENS = Intrinsics(160, 120, 1.0821)
GLOW = Light(ambient=1.0, diffuse=0.0)
HERE = Pose(0.0, 0.0, 0.3)
WHITE = (255, 255, 255)
COARSE = Texture(pattern="checker", scale_m=2.0, contrast=0.5)


def view(pitch: float = 0.0, pose: Pose = HERE) -> CameraView:
    return CameraView.of(LENS, Mount(z_m=0.4, pitch_rad=pitch), pose)


def apply_texture(world: WorldDescription, texture: Texture | None) -> WorldDescription:
    """Return the world in white with one texture on all surfaces, under a light that causes no shading."""
    white = {"colour": WHITE, "texture": texture}
    return world.model_copy(
        update={
            "light": GLOW,
            "floor": world.floor.model_copy(update=white),
            "walls": world.walls and world.walls.model_copy(update=white),
            "obstacles": tuple(obstacle.model_copy(update=white) for obstacle in world.obstacles),
        }
    )


def compute_grey(wrap: Wrap | None, points: np.ndarray) -> np.ndarray:
    """Return the grey levels of a white textured plane at these points."""
    assert wrap
    columns, rows = (np.floor(TILE_PX * wrap.tiles(points)).astype(int) % TILE_PX).T
    return np.asarray(wrap.texture.tile[rows, columns])


def measure_match(got: np.ndarray, expected: np.ndarray) -> float:
    return float((np.abs(got.astype(int) - expected) <= 1).mean())


def test_pixel_of_the_floor_has_the_texel_at_the_end_of_its_ray() -> None:
    for pitch, pattern in product([0.0, 0.5, -0.1], [pattern for pattern in PATTERNS if pattern != "plain"]):
        world = apply_texture(room(), Texture(pattern=pattern, scale_m=2.0, contrast=0.5))
        seen = view(pitch)
        rays = compute_rays(seen)
        near = -rays[..., 2] > 0.3 * LENS.focal_length
        points = seen.eye + rays[near] * (seen.eye[2] / -rays[near][:, 2:])
        assert near.sum() > 500
        image, expected = Painter(world).picture(seen), compute_grey(floor_wrap(world.floor), points)
        assert measure_match(image[near][:, 0], expected) > 0.97, (pitch, pattern)


@pytest.mark.slow
def test_pixel_of_a_prism_has_the_texel_at_the_end_of_its_ray() -> None:
    prisms = box(1.4, 0.7, 0.3, 0.5, yaw=0.4, height=0.5), post(1.2, 0.1, 0.2, height=0.5)
    world = apply_texture(room(*prisms, walls=Walls(height_m=0.5)), COARSE)
    seen = view()
    labels, depths, rays = trace_labels(world, seen), trace_depths(world, seen), compute_rays(seen)
    image = Painter(world).picture(seen)
    for number in np.unique(labels[labels > 0]):
        prism, shown = world.prisms[number - 1], labels == number
        points = seen.eye + depths[number][shown][:, None] * rays[shown]
        normals = [_find_normal(prism.outline, point) for point in points]
        expected = [compute_grey(face_wrap(prism, n), p[None])[0] for n, p in zip(normals, points, strict=True)]
        assert measure_match(image[shown][:, 0], np.array(expected)) > 0.97


def _find_normal(outline: tuple[tuple[float, float], ...], point: np.ndarray) -> np.ndarray:
    corners = np.array(outline)
    ways = np.roll(corners, -1, axis=0) - corners
    normals = np.stack((ways[:, 1], -ways[:, 0]), axis=1) / np.linalg.norm(ways, axis=1)[:, None]
    side = np.abs(((point[:2] - corners) * normals).sum(axis=1)).argmin()
    return np.array((*normals[side], 0.0))


def test_ball_has_no_pattern() -> None:
    world = apply_texture(room(ball(1.0, 0.3)), COARSE)
    shown = Painter(world).labels(view()) == 1
    green = Painter(world).picture(view())[shown]
    assert len(green) > 50
    assert len(np.unique(green, axis=0)) == 1


def test_distant_pattern_has_its_mean_brightness() -> None:
    fine = Texture(pattern="checker", scale_m=0.02, contrast=0.5)
    world = apply_texture(room(), fine)
    image: Image = Painter(world).picture(view())
    horizon = image[62:70, :, 0]
    assert np.ptp(horizon) == 0
    assert horizon[0, 0] == pytest.approx(fine.tile.mean(), abs=1)


def test_pattern_is_applied_before_bright_light_saturates() -> None:
    light = Light(ambient=1.0, diffuse=0.0, brightness=2.0)
    world = apply_texture(room(), Texture(pattern="checker", scale_m=2.0, contrast=0.6)).model_copy(
        update={"light": light}
    )
    levels = np.unique(Painter(world).picture(view(0.5))[100:, :, 0])
    assert levels.tolist() == [204, 255]


def test_edge_on_floor_raises_no_warning() -> None:
    world = apply_texture(room(), COARSE)
    through_a_row = CameraView.of(Intrinsics(161, 121, 1.0821), Mount(z_m=0.4), HERE)
    assert Painter(world).picture(through_a_row)[60, 0].tolist() == [235, 220, 205]
