from __future__ import annotations

import numpy as np
import pytest

from robotcore.description import Light, Mount, Texture, Walls, WorldDescription
from robotcore.description.meshes import Wrap, face_wrap, floor_wrap
from robotcore.description.texture import PATTERNS, TILE_PX, Pattern
from robotcore.geometry import Pose
from robotcore.hal.devices import Image
from robotcore.optics import CameraView, Intrinsics
from robotcore.simulation.painter import Painter
from tests.drivers.kinematic.rooms import ball, box, post, room
from tests.robotcore.simulation.painter.tracer import rays_of, traced_depths, traced_labels

LENS = Intrinsics(160, 120, 1.0821)
GLOW = Light(ambient=1.0, diffuse=0.0)
HERE = Pose(0.0, 0.0, 0.3)
WHITE = (255, 255, 255)
COARSE = Texture(pattern="checker", scale_m=2.0, contrast=0.5)


def view(pitch: float = 0.0, pose: Pose = HERE) -> CameraView:
    return CameraView.of(LENS, Mount(z_m=0.4, pitch_rad=pitch), pose)


def textured(world: WorldDescription, texture: Texture | None) -> WorldDescription:
    """Return a white world under a light without shade, with one texture everywhere."""
    white = {"colour": WHITE, "texture": texture}
    return world.model_copy(
        update={
            "light": GLOW,
            "floor": world.floor.model_copy(update=white),
            "walls": world.walls and world.walls.model_copy(update=white),
            "obstacles": tuple(obstacle.model_copy(update=white) for obstacle in world.obstacles),
        }
    )


def grey_at(wrap: Wrap | None, points: np.ndarray) -> np.ndarray:
    """Return how bright white paint is at points of a textured plane."""
    assert wrap
    columns, rows = (np.floor(TILE_PX * wrap.tiles(points)).astype(int) % TILE_PX).T
    return np.asarray(wrap.texture.tile[rows, columns])


def agreement(got: np.ndarray, expected: np.ndarray) -> float:
    return float((np.abs(got.astype(int) - expected) <= 1).mean())


@pytest.mark.parametrize("pitch", [0.0, 0.5, -0.1])
@pytest.mark.parametrize("pattern", [pattern for pattern in PATTERNS if pattern != "plain"])
def test_every_pixel_of_the_floor_shows_where_its_ray_meets_it(pattern: Pattern, pitch: float) -> None:
    world = textured(room(), Texture(pattern=pattern, scale_m=2.0, contrast=0.5))
    seen = view(pitch)
    rays = rays_of(seen)
    near = -rays[..., 2] > 0.3 * LENS.focal_length
    points = seen.eye + rays[near] * (seen.eye[2] / -rays[near][:, 2:])
    assert near.sum() > 500
    assert agreement(Painter(world).picture(seen)[near][:, 0], grey_at(floor_wrap(world.floor), points)) > 0.97


def test_every_pixel_of_a_thing_shows_where_its_ray_meets_it() -> None:
    things = box(1.4, 0.7, 0.3, 0.5, yaw=0.4, height=0.5), post(1.2, 0.1, 0.2, height=0.5)
    world = textured(room(*things, walls=Walls(height_m=0.5)), COARSE)
    seen = view()
    labels, depths, rays = traced_labels(world, seen), traced_depths(world, seen), rays_of(seen)
    image = Painter(world).picture(seen)
    for number in np.unique(labels[labels > 0]):
        prism, shown = world.prisms[number - 1], labels == number
        points = seen.eye + depths[number][shown][:, None] * rays[shown]
        normals = [_side_at(prism.outline, point) for point in points]
        expected = [grey_at(face_wrap(prism, n), p[None])[0] for n, p in zip(normals, points, strict=True)]
        assert agreement(image[shown][:, 0], np.array(expected)) > 0.97


def _side_at(outline: tuple[tuple[float, float], ...], point: np.ndarray) -> np.ndarray:
    """Return the normal of the side of a prism that a point lies on."""
    corners = np.array(outline)
    ways = np.roll(corners, -1, axis=0) - corners
    normals = np.stack((ways[:, 1], -ways[:, 0]), axis=1) / np.linalg.norm(ways, axis=1)[:, None]
    side = np.abs(((point[:2] - corners) * normals).sum(axis=1)).argmin()
    return np.array((*normals[side], 0.0))


def test_a_picture_is_the_plain_one_where_nothing_has_a_pattern() -> None:
    world = room(box(1.4, 0.7, 0.3, 0.5), ball(1.0, 0.0), walls=Walls(height_m=0.5))
    plain = Painter(world).picture(view())
    floor = world.floor.model_copy(update={"texture": COARSE})
    patterned = Painter(world.model_copy(update={"floor": floor})).picture(view())
    is_floor = _is_floor(world)
    assert np.array_equal(patterned[~is_floor], plain[~is_floor])
    assert not np.array_equal(patterned[is_floor], plain[is_floor])


def _is_floor(world: WorldDescription) -> np.ndarray:
    return np.asarray((Painter(world).labels(view()) == 0) & (rays_of(view())[..., 2] < 0))


def test_a_ball_and_the_sky_have_no_pattern() -> None:
    world = textured(room(ball(1.0, 0.3)), COARSE)
    shown = Painter(world).labels(view()) == 1
    green = Painter(world).picture(view())[shown]
    assert len(green) > 50
    assert len(np.unique(green, axis=0)) == 1


def test_far_away_a_pattern_fades_to_its_mean() -> None:
    fine = Texture(pattern="checker", scale_m=0.02, contrast=0.5)
    world = textured(room(), fine)
    image: Image = Painter(world).picture(view())
    horizon = image[62:70, :, 0]
    assert np.ptp(horizon) == 0
    assert horizon[0, 0] == pytest.approx(fine.tile.mean(), abs=1)


def test_bright_light_saturates_after_the_pattern_has_darkened() -> None:
    light = Light(ambient=1.0, diffuse=0.0, brightness=2.0)
    world = textured(room(), Texture(pattern="checker", scale_m=2.0, contrast=0.6)).model_copy(update={"light": light})
    levels = np.unique(Painter(world).picture(view(0.5))[100:, :, 0])
    assert levels.tolist() == [204, 255]


def test_what_is_seen_edge_on_warns_of_nothing() -> None:
    world = textured(room(), COARSE)
    through_a_row = CameraView.of(Intrinsics(161, 121, 1.0821), Mount(z_m=0.4), HERE)
    assert Painter(world).picture(through_a_row)[60, 0].tolist() == [235, 220, 205]
