"""The colour of an object."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from robotcore.autonomy.vision import ColourDetector
from robotcore.calibration.camera.object_colour import measure_hue
from robotcore.errors import CalibrationError, UnknownNameError
from robotcore.optics import Image, Intrinsics
from tests.texts import Raises

EYE = Intrinsics(160, 120, 1.0)


def draw(hue: float, saturation: float = 0.7, value: float = 0.6, others: int = 0) -> Image:
    """Return a picture with a disc of a hue in degrees whose brightness varies, and further small ones."""
    picture = np.full((120, 160, 3), 120, np.uint8)
    places = [((80, 60), 18), *(((15 + 30 * number, 15), 6) for number in range(others))]
    for place, radius in places:
        for ring in range(radius, 0, -1):
            shade = value * (0.7 + 0.3 * ring / radius)
            rgb = cv2.cvtColor(np.array([[[hue, saturation, shade]]], np.float32), cv2.COLOR_HSV2BGR)[0, 0] * 255
            cv2.circle(picture, place, ring, [float(each) for each in rgb], cv2.FILLED)
    return picture


@pytest.mark.parametrize("hue", [128.0, 112.0, 148.0])
def test_the_measured_limits_let_a_detector_find_the_object(hue: float) -> None:
    fit = measure_hue([draw(hue)] * 4, "green", EYE)
    assert fit.hue == pytest.approx(hue, abs=2)
    assert 15 <= fit.tolerance <= 20
    assert fit.found_share == 1.0
    assert not fit.warnings
    assert len(ColourDetector(fit.hue, tolerance=fit.tolerance).find(draw(hue), EYE)) == 1


def test_a_red_object_is_measured_across_the_end_of_the_circle() -> None:
    fit = measure_hue([draw(358.0)] * 2, "red", EYE)
    assert min(abs(fit.hue - 358), abs(fit.hue - 358 + 360)) < 2.5


def test_a_pale_object_other_objects_and_too_much_light_are_warned_about() -> None:
    assert "saturation" in measure_hue([draw(128.0, saturation=0.2)], "green", EYE).warnings[0]
    assert "2 other things" in measure_hue([draw(128.0, others=2)], "green", EYE).warnings[0]
    assert "overexposed" in measure_hue([draw(128.0, value=1.4)], "green", EYE).warnings[0]


def test_a_missing_object_is_refused(raises: Raises) -> None:
    with raises(CalibrationError, "no-object", colour="blue"):
        measure_hue([draw(128.0)], "blue", EYE)


def test_an_unknown_colour_is_refused(raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-hue"):
        measure_hue([draw(128.0)], "gren", EYE)
