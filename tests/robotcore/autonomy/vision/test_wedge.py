from __future__ import annotations

import colorsys
import doctest

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.autonomy.vision import wedge
from robotcore.autonomy.vision.wedge import Wedge, passed
from tests.robotcore.autonomy.vision.pictures import bgr

HUE = st.floats(0, 360, allow_nan=False)
PART = st.floats(0.2, 1)


def does_pass(colour: tuple[int, int, int], tests: wedge.Tests) -> bool:
    return bool(passed(np.full((1, 1, 3), colour, np.uint8), tests)[0, 0])


def test_the_example_holds() -> None:
    assert doctest.testmod(wedge) == doctest.TestResults(failed=0, attempted=2)


@given(HUE, PART, PART)
def test_chroma_and_saturation_of_the_hue_itself_are_those_of_hsv(hue: float, saturation: float, value: float) -> None:
    red, green, blue = colorsys.hsv_to_rgb(hue / 360, saturation, value)
    found, colour = Wedge(hue, 30), (255 * blue, 255 * green, 255 * red)
    assert found.chroma(colour) == pytest.approx(255 * saturation * value, rel=0.14)
    assert found.saturation(colour) == pytest.approx(saturation, rel=0.14)


@given(HUE, PART, st.floats(0.2, 0.7), st.floats(0.2, 1))
def test_saturation_stays_in_the_shadow(hue: float, saturation: float, value: float, light: float) -> None:
    lit, dim = (255 * np.array(colorsys.hsv_to_rgb(hue / 360, saturation, part)) for part in (value, value * light))
    found = Wedge(hue, 30)
    assert found.saturation(tuple(dim[::-1])) == pytest.approx(found.saturation(tuple(lit[::-1])), abs=0.02)


@given(HUE, st.floats(5, 80), st.sampled_from((-1, 1)))
def test_a_hue_passes_within_the_tolerance_and_not_beyond(hue: float, tolerance: float, side: int) -> None:
    tests = Wedge(hue, tolerance).of_chroma(0.0)
    assert does_pass(bgr(hue + side * (tolerance - 3)), tests)
    assert not does_pass(bgr(hue + side * (tolerance + 3)), tests)
    assert not does_pass(bgr(hue + 180), tests)


@given(HUE, st.floats(0.2, 0.8))
def test_a_saturation_passes_from_the_least_on(hue: float, least: float) -> None:
    tests = Wedge(hue, 30).of_saturation(least, 0.0)
    assert does_pass(bgr(hue, min(1.0, least + 0.15)), tests)
    assert not does_pass(bgr(hue, least - 0.1), tests)


@given(HUE, st.sampled_from((-1, 1)))
def test_the_duller_a_colour_the_nearer_to_the_hue_it_must_be(hue: float, side: int) -> None:
    tests, aside = Wedge(hue, 30).of_saturation(0.25, 0.0), hue + 25 * side
    assert does_pass(bgr(aside, 0.9), tests)
    assert not does_pass(bgr(aside, 0.35), tests)
    assert does_pass(bgr(hue, 0.45), tests)


@given(HUE, st.integers(0, 255))
def test_grey_never_passes_once_there_is_a_distance(hue: float, grey: int) -> None:
    assert not does_pass((grey, grey, grey), Wedge(hue, 30).of_saturation(0.0, 2.0))


def test_a_distance_asks_more_of_the_dark() -> None:
    tests = Wedge(120, 30).of_saturation(0.3, 10.0)
    assert does_pass(bgr(120, 0.5, 0.9), tests)
    assert not does_pass(bgr(120, 0.5, 0.1), tests)
