"""The noise of pixels, and pictures without content."""

from __future__ import annotations

import numpy as np
import pytest

from robotcore.calibration.camera.measuring import require_content
from robotcore.calibration.camera.pixel_noise import measure_noise
from robotcore.errors import CalibrationError
from robotcore.optics import Image
from tests.texts import Raises


def draw_noise(sigma: float, lowest: int = 40, highest: int = 200) -> list[Image]:
    """Return pictures of a scene with grey levels between two limits, with noise and a flickering lamp."""
    random = np.random.default_rng(1)
    scene = random.integers(lowest, highest, (60, 80, 3))
    return [
        np.clip(np.rint(scene + random.normal(0, sigma, scene.shape) + random.normal(0, 1)), 0, 255).astype(np.uint8)
        for _ in range(20)
    ]


@pytest.mark.parametrize("sigma", [0.0, 1.0, 4.0])
def test_noise_is_measured_despite_rounding_and_a_flickering_lamp(sigma: float) -> None:
    assert measure_noise(draw_noise(sigma)) == pytest.approx(sigma, abs=0.3 if sigma == 0 else 0.05)


@pytest.mark.parametrize("sigma", [16.0, 32.0])
def test_strong_noise_is_measured_by_the_pixels_that_are_far_from_black_and_white(sigma: float) -> None:
    assert measure_noise(draw_noise(sigma, 0, 256)) == pytest.approx(sigma, rel=0.02)


def test_noise_that_black_and_white_cut_off_is_refused(raises: Raises) -> None:
    with raises(CalibrationError, "noise-too-strong"):
        measure_noise(draw_noise(64.0))


def test_too_few_or_black_pictures_give_no_noise(raises: Raises) -> None:
    with raises(CalibrationError, "too-few-pictures", pictures=2):
        measure_noise(draw_noise(1.0)[:2])
    with raises(CalibrationError, "no-grey-pixels"):
        measure_noise([np.zeros((20, 20, 3), np.uint8)] * 8)


def test_pictures_of_one_grey_level_are_refused(raises: Raises) -> None:
    require_content(draw_noise(0.0)[:1])
    with raises(CalibrationError, "empty-pictures"):
        require_content([np.full((20, 20, 3), 7, np.uint8)])
