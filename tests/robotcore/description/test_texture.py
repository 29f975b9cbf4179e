from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.description import Cylinder, Floor, Texture
from robotcore.description.meshes import Wrap, face_wrap, floor_wrap
from robotcore.description.texture import PATTERNS, TILE_PX, Pattern
from robotcore.description.world import Box
from robotcore.geometry import Pose

CHECKER = Texture(pattern="checker", scale_m=0.5)
BOX = Box(shape="box", name="box", colour=(9, 9, 9), length_m=0.4, width_m=0.2, height_m=0.3, texture=CHECKER)
POST = Cylinder(shape="cylinder", name="post", colour=(9, 9, 9), radius_m=0.2, height_m=0.3, texture=CHECKER)
SIDE, TOP = np.array((1.0, 0.0, 0.0)), np.array((0.0, 0.0, 1.0))


def place(wrap: Wrap | None, *point: float) -> tuple[float, float]:
    assert wrap
    along, up = wrap.tiles(np.array((point,)))[0].tolist()
    return along, up


@pytest.mark.parametrize("pattern", PATTERNS)
def test_tile_darkens_by_at_most_its_contrast(pattern: Pattern) -> None:
    tile = Texture(pattern=pattern, contrast=0.4).tile
    assert tile.shape == (TILE_PX, TILE_PX)
    assert tile.dtype == np.uint8
    assert tile.min() >= round(255 * 0.6)
    assert (np.ptp(tile) > 40) == (pattern != "plain")


def test_patterns_are_those_of_earlier_versions() -> None:
    means = {pattern: float(Texture(pattern=pattern, contrast=0.9).tile.mean()) for pattern in PATTERNS}
    assert means == pytest.approx(
        {"plain": 255.0, "checker": 140.0, "planks": 173.86, "speckle": 140.04, "grass": 138.74}, abs=0.01
    )


def test_a_floor_is_tiled_from_its_middle_along_x_and_y() -> None:
    wrap = floor_wrap(Floor(length_m=4, width_m=4, texture=CHECKER))
    assert place(wrap, 0.0, 0.0, 0.0) == (0.0, 0.0)
    assert place(wrap, 1.0, -0.25, 0.0) == (2.0, -0.5)


def test_surface_without_texture_has_no_mapping() -> None:
    assert floor_wrap(Floor(length_m=4, width_m=4)) is None
    assert face_wrap(BOX.model_copy(update={"texture": None}), SIDE) is None


def test_a_side_begins_at_the_floor_in_the_middle_of_a_box() -> None:
    here = BOX.model_copy(update={"x_m": 3.0, "y_m": 1.0})
    assert place(face_wrap(here, SIDE), 3.2, 1.0, 0.0) == pytest.approx((0.0, 0.0))
    assert place(face_wrap(here, SIDE), 3.2, 1.1, 0.3) == pytest.approx((0.2, 0.6))


@pytest.mark.parametrize("thing", [BOX, POST], ids=["box", "post"])
@pytest.mark.parametrize("normal", [SIDE, TOP], ids=["side", "top"])
def test_texture_moves_and_turns_with_its_body(thing: Box | Cylinder, normal: np.ndarray) -> None:
    pose = Pose(0.7, -0.4, 2.5)
    moved = thing.model_copy(update={"x_m": pose.x, "y_m": pose.y, "yaw_rad": pose.heading})
    point = np.array((0.2, 0.07, 0.11))
    there = (*pose.to_world(*point[:2]), point[2])
    turned = np.array((*Pose(0.0, 0.0, pose.heading).to_world(*normal[:2]), normal[2]))
    assert place(face_wrap(moved, turned), *there) == pytest.approx(place(face_wrap(thing, normal), *point))


def test_texture_continues_from_side_to_side_of_a_cylinder() -> None:
    middles = [math.tau / 24 * (side + 0.5) for side in range(-12, 12)]
    wraps = [face_wrap(POST, np.array((math.cos(angle), math.sin(angle), 0.0))) for angle in middles]
    for one, other, corner in zip(wraps, wraps[1:], POST.outline[13:] + POST.outline[:12], strict=False):
        assert place(one, *corner, 0.1) == pytest.approx(place(other, *corner, 0.1), abs=0.001)
