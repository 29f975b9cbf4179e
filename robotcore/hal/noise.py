"""Random numbers for simulated noise. A key and a time determine each number, so that equal runs have equal noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import numpy as np
from numpy.typing import NDArray

from robotcore.optics import Image


def random_at(key: str, time: float) -> Random:
    """Return a random generator. Its seed is a key and a time in seconds, rounded to microseconds."""
    return Random(f"{key}:{round(1e6 * time)}")


def draw_noise(key: str, sigma: float, time: float) -> float:
    """Return normal noise with the standard deviation ``sigma`` at a time in seconds.

    The method is that of Box and Muller (1958).

    >>> draw_noise("1:nose", 0.01, 0.25) == draw_noise("1:nose", 0.01, 0.25)
    True
    """
    random = random_at(key, time)
    radius = math.sqrt(-2 * math.log(1 - random.random()))
    return sigma * radius * math.cos(math.tau * random.random())


def draw_noises(key: str, sigma: float, time: float, count: int) -> NDArray[np.float64]:
    """Return ``count`` values of normal noise with the standard deviation ``sigma`` at a time in seconds.

    >>> draw_noises("1:scanner", 0.01, 0.25, 3).tolist() == draw_noises("1:scanner", 0.01, 0.25, 3).tolist()
    True
    """
    # NumPy guarantees the same numbers in every version only for RandomState.
    generator = np.random.RandomState(random_at(key, time).getrandbits(32))
    return sigma * generator.standard_normal(count)


STRIP_POSITIONS = 1 << 16
"""The number of positions in the long array of random numbers at which a picture's noise can begin."""


class Noise:
    """The normal noise of one device. ``sigma`` is its standard deviation.

    The seed, the device and the time determine each value.

    >>> noise = Noise(seed=1, device="nose", sigma=0.01)
    >>> noise.draw_number(0.25) == noise.draw_number(0.25), noise.draw_number(0.25) == noise.draw_number(0.5)
    (True, False)
    """

    def __init__(self, seed: int, device: str, sigma: float) -> None:
        self._key = f"{seed}:{device}"
        self._sigma = sigma
        self._strip: NDArray[np.int16] = np.empty(0, dtype=np.int16)

    def draw_number(self, time: float) -> float:
        """Return the noise of a value that was captured at ``time``, in seconds."""
        return draw_noise(self._key, self._sigma, time)

    def draw_picture(self, shape: tuple[int, ...], time: float) -> NDArray[np.int16]:
        """Return the noise of a picture that was captured at ``time``, in seconds: an ``int16`` array in grey levels.

        The result is a section of one long array, and the time selects the section. New random numbers for each picture
        would take longer than the simulation of the picture.
        """
        size = math.prod(shape)
        if len(self._strip) < STRIP_POSITIONS + size:
            self._strip = self._draw_strip(STRIP_POSITIONS + size)
        start = int(STRIP_POSITIONS * random_at(self._key, time).random())
        return self._strip[start : start + size].reshape(shape)

    def _draw_strip(self, length: int) -> NDArray[np.int16]:
        # NumPy guarantees the same numbers in every version only for RandomState.
        generator = np.random.RandomState(Random(self._key).getrandbits(32))
        return np.rint(_deviation_before_rounding(self._sigma) * generator.standard_normal(length)).astype(np.int16)


def _deviation_before_rounding(sigma: float) -> float:
    """Return the deviation of normal noise whose deviation after rounding is ``sigma``. The method is bisection.

    Rounding to whole numbers changes a standard deviation: 0.2 becomes 0.11, and 1 becomes 1.04.
    """
    low, high = 0.0, sigma + 1
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if _deviation_after_rounding(middle) < sigma else (low, middle)
    return high


def _deviation_after_rounding(sigma: float) -> float:
    # The variance after rounding is the sum of (2k - 1) · P(abs(x) > k - 1/2) over k = 1, 2, …
    beyond = (math.erfc((k - 0.5) / (sigma * math.sqrt(2))) for k in range(1, math.ceil(8 * sigma) + 2))
    return math.sqrt(sum((2 * k - 1) * share for k, share in enumerate(beyond, start=1)))


def build_noise_effect(noise: Noise) -> Callable[[Image, float], Image]:
    """Return an effect that adds noise to pictures, limited to grey levels from 0 to 255."""
    import cv2

    def add_noise(image: Image, time: float) -> Image:
        return np.asarray(cv2.add(image, noise.draw_picture(image.shape, time), dtype=cv2.CV_8U), dtype=np.uint8)

    return add_noise
