from __future__ import annotations

import math

import pytest

from robotcore.autonomy.vision import HUE_RANGES, HUES, ColourDetector, parse_hue
from robotcore.autonomy.vision.colour_detector import limit_tolerance
from robotcore.description import COLOURS, hue_degrees
from robotcore.errors import UnknownNameError, UsageError
from tests.robotcore.autonomy.vision.pictures import INTRINSICS, bgr, draw_rectangles
from tests.texts import Raises


@pytest.mark.parametrize(
    "hue, degrees", [("green", 128.0), ("red", 0.0), (90, 90.0), ("90", 90.0), (-30, 330.0), (720.5, 0.5)]
)
def test_hue_is_a_name_or_degrees(hue: str | float, degrees: float) -> None:
    assert parse_hue(hue) == degrees


def test_unknown_name_suggests_the_nearest_name(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-hue"):
        ColourDetector("gren")


@pytest.mark.parametrize("hue", ["nan", math.inf])
def test_hue_that_is_not_finite_is_refused(raises: Raises, hue: str | float) -> None:
    with raises(UsageError, "no-hue", hue=hue):
        parse_hue(hue)


def test_a_named_hue_is_that_of_the_colour_of_that_name_in_a_world() -> None:
    for name, hue in HUES.items():
        away = (hue_degrees(COLOURS[name]) - hue + 180) % 360 - 180
        assert abs(away) < 5, name


def test_each_range_of_a_name_begins_where_the_previous_one_ends() -> None:
    ranges = [HUE_RANGES[name] for name in sorted(HUES, key=HUES.__getitem__)]
    assert [begin % 360 for begin, _ in ranges] == [end for _, end in ranges[-1:] + ranges[:-1]]


@pytest.mark.parametrize("shift", [-8, 0, 8])
def test_colour_is_found_by_its_own_name_only(shift: float) -> None:
    """By default, ``--randomise`` shifts the hue of a ball by up to 8 degrees."""
    detectors = {hue: ColourDetector(hue) for hue in HUES}
    for name in HUES:
        image = draw_rectangles((bgr(hue_degrees(COLOURS[name]) + shift, 0.8), (10, 10, 8, 8)))
        assert [hue for hue, detector in detectors.items() if detector.find(image, INTRINSICS)] == [name]


@pytest.mark.parametrize(
    "hue, tolerance, limited",
    [
        ("green", 30.0, (30.0, 30.0)),
        ("orange", 30.0, (14.0, 12.5)),
        ("orange", 13.0, (13.0, 12.5)),
        ("red", 80.0, (22.0, 14.0)),
        ("28", 30.0, (30.0, 30.0)),
        (28, 30.0, (30.0, 30.0)),
    ],
)
def test_range_of_a_name_ends_at_the_next_name_and_that_of_degrees_does_not(
    hue: str | float, tolerance: float, limited: tuple[float, float]
) -> None:
    assert limit_tolerance(hue, tolerance) == limited
