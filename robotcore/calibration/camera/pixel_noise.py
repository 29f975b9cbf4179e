"""Measures the noise of a camera's pixels, in the present light."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robotcore.errors import CalibrationError
from robotcore.optics import Image

MIN_NOISE_PICTURES = 8
"""The least number of pictures from which the noise is measured."""

BLACK, WHITE = 0.0, 255.0
"""The limits of a picture, which cut the noise of dark and bright pixels off."""

MIN_MARGIN, MARGIN_DEVIATIONS = 12.0, 2.5
"""A pixel is left out if its mean is nearer to a limit of the picture, in grey levels or in deviations of its noise."""

MIN_GREY_SHARE = 0.05
"""The least share of the pixels from which the noise is measured."""

NOISE_PASSES = 3
"""The number of estimates of the noise. Each leaves out the pixels that the last one showed to be cut off."""

ROUNDING_VARIANCE = 1 / 12
"""The variance that rounding to whole grey levels adds."""


def measure_noise(pictures: Sequence[Image]) -> float:
    """Return the standard deviation of a pixel's noise, in grey levels.

    pictures: pictures of a scene at rest, each (height, width, 3).

    Raises CalibrationError if there are too few pictures, if they are too dark or too bright, or if the noise is too
    strong.
    """
    if len(pictures) < MIN_NOISE_PICTURES:
        raise CalibrationError(
            f"{len(pictures)} pictures are too few to measure the noise; {MIN_NOISE_PICTURES} are needed",
            kind="too-few-pictures",
            pictures=len(pictures),
        )
    stack = np.stack(pictures).astype(np.float32)
    stack -= stack.mean(axis=(1, 2), keepdims=True) - stack.mean(axis=(0, 1, 2))  # lamps flicker
    middle, variances = stack.mean(axis=0), stack.var(axis=0, ddof=1)
    count = len(pictures) - 1
    median = (1 - 2 / (9 * count)) ** 3  # of a chi-squared distribution, divided by its mean
    noise = 0.0
    for _ in range(NOISE_PASSES):
        margin = max(MIN_MARGIN, MARGIN_DEVIATIONS * noise)
        is_valid = (middle > BLACK + margin) & (middle < WHITE - margin)
        if is_valid.mean() < MIN_GREY_SHARE:
            raise _build_noise_error(noise)
        noise = math.sqrt(max(float(np.median(variances[is_valid])) / median - ROUNDING_VARIANCE, 0.0))
    return noise


def _build_noise_error(noise: float) -> CalibrationError:
    """Return the error for pictures of which hardly a pixel is grey.

    noise: the standard deviation of the pixels that the first estimate did not leave out; 0 if it left all out.
    """
    if not noise:
        text = "nearly all pixels are black or white. Change the light, or the exposure of the camera"
        return CalibrationError(text, kind="no-grey-pixels")
    return CalibrationError(
        f"the noise is about {noise:.0f} grey levels, and black and white cut it off in nearly all pixels, so that it "
        "cannot be measured. Give the camera more light, set exposure_s, or let it see a grey wall",
        kind="noise-too-strong",
        noise_levels=noise,
    )
