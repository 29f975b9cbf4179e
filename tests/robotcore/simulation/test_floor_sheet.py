"""The texture with the picture and the lines on the floor, for simulators that draw textures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robotcore.description import Line, WorldDescription, load_world
from robotcore.description.floor_colours import FloorColours
from robotcore.simulation.floor_sheet import MAX_SIDE, MAX_TEXELS, TEXEL_M, FloorSheet, draw_floor_sheet
from tests.robotcore.description.courses import COURSE, load_course

PATTERN = 'texture = { pattern = "checker" }\ncolour ='
LINE = "[[lines]]\nwidth_m = 0.1\npoints_m = [[-1.0, 0.0], [1.0, 0.5]]\ncolour = 'red'\n" * 2
OPEN = load_world("open")


def draw(world: WorldDescription) -> FloorSheet:
    sheet = draw_floor_sheet(world)
    assert sheet
    return sheet


def measure_texel(sheet: FloorSheet) -> float:
    """Return the width of a texel in metres."""
    left, bottom, right, top = sheet.rectangle
    rows, columns = sheet.pixels.shape[:2]
    assert (right - left) / columns == pytest.approx((top - bottom) / rows)
    return float((right - left) / columns)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", [COURSE, COURSE + LINE, COURSE.replace("colour =", PATTERN) + LINE], ids=["picture", "lines", "pattern"]
)
def test_each_texel_has_the_colour_of_the_floor_at_its_middle(tmp_path: Path, text: str) -> None:
    world = load_course(tmp_path, text=text)
    sheet = draw(world)
    texel = measure_texel(sheet)
    random = np.random.default_rng(1)
    rows, columns = (random.integers(0, side, 5000) for side in sheet.pixels.shape[:2])
    points = np.column_stack((columns, rows)) * texel + texel / 2 + sheet.rectangle[:2]
    colours = sheet.pixels[rows, columns]
    assert (np.abs(FloorColours(world).measure(points) - colours).max(axis=1) > 1).mean() < 0.001
    assert len(np.unique(colours, axis=0)) >= 4


def test_later_line_covers_an_earlier_one() -> None:
    lines = [Line(width_m=0.1, points_m=((0.0, 0.0), (1.0, 0.0)), colour=colour) for colour in ((9, 9, 9), (1, 2, 3))]
    sheet = draw(OPEN.model_copy(update={"lines": tuple(lines)}))
    middle = sheet.pixels.shape[0] // 2
    assert sheet.pixels[middle, 500].tolist() == [1, 2, 3]


def test_edge_of_the_sheet_has_the_colour_of_the_floor_and_overlaps_the_ground(tmp_path: Path) -> None:
    sheet = draw(load_course(tmp_path))
    edges = [sheet.pixels[0], sheet.pixels[-1], sheet.pixels[:, 0], sheet.pixels[:, -1]]
    assert all((edge == (200, 190, 180)).all() for edge in edges)
    half = measure_texel(sheet) / 2
    assert np.subtract(sheet.hole, sheet.rectangle) == pytest.approx((half, half, -half, -half))


@pytest.mark.parametrize(
    "ends, texel",
    [(((0.0, 0.0), (1.0, 0.5)), TEXEL_M), (((-40.0, -40.0), (40.0, 40.0)), None), (((-90.0, 0.0), (90.0, 0.0)), None)],
    ids=["small", "large", "long"],
)
def test_large_sheet_has_wider_texels(ends: tuple[tuple[float, float], ...], texel: float | None) -> None:
    sheet = draw(OPEN.model_copy(update={"lines": (Line(width_m=0.1, points_m=ends),)}))
    rows, columns = sheet.pixels.shape[:2]
    assert (rows - 3) * (columns - 3) <= MAX_TEXELS
    assert max(rows, columns) <= MAX_SIDE + 3
    assert measure_texel(sheet) == pytest.approx(texel) if texel else measure_texel(sheet) > 2 * TEXEL_M


def test_plain_floor_has_no_sheet() -> None:
    assert draw_floor_sheet(OPEN) is None
