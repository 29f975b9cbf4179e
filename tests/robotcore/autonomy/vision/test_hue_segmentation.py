from __future__ import annotations

import colorsys

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from robotcore.autonomy.vision import hue_segmentation as regions
from robotcore.autonomy.vision.hue_segmentation import HueClassifier, Region, find_contours, find_hue, measure_region
from tests.robotcore.autonomy.vision.pictures import bgr

HUE = st.floats(0, 360, allow_nan=False)
PART = st.floats(0.2, 1)


def passes(colour: tuple[int, int, int], tests: regions.Tests) -> bool:
    return bool(find_hue(np.full((1, 1, 3), colour, np.uint8), tests)[0, 0])


@given(HUE, PART, PART)
def test_chroma_and_saturation_of_the_hue_itself_are_those_of_hsv(hue: float, saturation: float, value: float) -> None:
    red, green, blue = colorsys.hsv_to_rgb(hue / 360, saturation, value)
    found, colour = HueClassifier(hue, 30, 30), (255 * blue, 255 * green, 255 * red)
    assert found.chroma(colour) == pytest.approx(255 * saturation * value, rel=0.14)
    assert found.saturation(colour) == pytest.approx(saturation, rel=0.14)


@given(HUE, st.floats(5, 80), st.floats(5, 80))
def test_hues_pass_within_the_tolerance_only(hue: float, below: float, above: float) -> None:
    tests = HueClassifier(hue, below, above).of_chroma(0.0)
    for inside in (3 - below, above - 3):
        assert passes(bgr(hue + inside), tests)
    for outside in (-3 - below, above + 3, 180):
        assert not passes(bgr(hue + outside), tests)


@given(HUE, st.floats(0.2, 0.8))
def test_colours_pass_from_the_least_saturation_on(hue: float, least: float) -> None:
    tests = HueClassifier(hue, 30, 30).of_saturation(least, 0.0)
    assert passes(bgr(hue, min(1.0, least + 0.15)), tests)
    assert not passes(bgr(hue, least - 0.1), tests)


@given(HUE, st.sampled_from((-1, 1)))
def test_dull_colours_must_be_nearer_to_the_hue(hue: float, side: int) -> None:
    tests, aside = HueClassifier(hue, 30, 30).of_saturation(0.25, 0.0), hue + 25 * side
    assert passes(bgr(aside, 0.9), tests)
    assert not passes(bgr(aside, 0.35), tests)
    assert passes(bgr(hue, 0.45), tests)


@given(HUE)
def test_dull_colours_have_a_range_on_each_side_of_the_hue(hue: float) -> None:
    tests = HueClassifier(hue, 12, 40).of_saturation(0.25, 0.0)
    assert passes(bgr(hue + 22, 0.5), tests)
    assert not passes(bgr(hue - 22, 0.5), tests)


@given(HUE, st.integers(0, 255))
def test_grey_never_passes_with_a_distance(hue: float, grey: int) -> None:
    assert not passes((grey, grey, grey), HueClassifier(hue, 30, 30).of_saturation(0.0, 2.0))


def test_dark_colours_need_more_saturation() -> None:
    tests = HueClassifier(120, 30, 30).of_saturation(0.3, 10.0)
    assert passes(bgr(120, 0.5, 0.9), tests)
    assert not passes(bgr(120, 0.5, 0.1), tests)


Rectangle = tuple[int, int, int, int]
RECTANGLE = st.tuples(st.integers(0, 30), st.integers(0, 20), st.integers(1, 12), st.integers(1, 12))
ELLIPSE = st.tuples(st.integers(2, 14), st.integers(2, 14), st.integers(0, 179))


def draw_mask(*rectangles: Rectangle) -> NDArray[np.uint8]:
    mask = np.zeros((40, 50), np.uint8)
    for left, top, width, height in rectangles:
        mask[top : top + height, left : left + width] = 1
    return mask


def measure_only_region(mask: NDArray[np.uint8]) -> Region:
    (outline,) = find_contours(mask)
    return measure_region(outline)


@given(ELLIPSE)
def test_the_centroid_is_that_of_the_pixels(ellipse: tuple[int, int, int]) -> None:
    across, down, turned = ellipse
    mask = np.zeros((40, 50), np.uint8)
    cv2.ellipse(mask, (20, 15), (across, down), turned, 0, 300, 1, cv2.FILLED)
    rows, columns = np.nonzero(mask)
    assert measure_only_region(mask).centroid == pytest.approx((columns.mean(), rows.mean()), abs=0.2)


def test_holes_are_filled() -> None:
    mask = draw_mask((10, 10, 12, 9))
    mask[13:15, 12:20] = 0
    assert measure_only_region(mask) == measure_only_region(draw_mask((10, 10, 12, 9)))


def test_patches_that_touch_at_a_corner_are_one() -> None:
    assert measure_only_region(draw_mask((5, 5, 3, 3), (8, 8, 4, 4))).area == 25


def test_outlines_are_moved_by_the_offset() -> None:
    (outline,) = find_contours(draw_mask((5, 6, 3, 3)), (100, 200))
    assert measure_region(outline).box == (105, 206, 3, 3)


def test_lies_in_a_box_up_to_its_edge() -> None:
    patch = Region((10.0, 5.0), (8, 3, 5, 5), 25)
    assert patch.lies_in((10, 5, 1, 1))
    assert not patch.lies_in((11, 5, 4, 4))
    assert not patch.lies_in((4, 5, 6, 4))
