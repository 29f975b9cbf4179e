"""Noise that belongs to the instant, not to the reading: reading more or less often changes nothing."""

from __future__ import annotations

import math
from random import Random

import numpy as np
from numpy.typing import NDArray

STRIP_STARTS = 1 << 16
"""From how many places a picture's noise may be cut out of its strip."""


class Noise:
    """Normal noise of one device, drawn anew for each instant from the run's seed; ``sigma`` is its deviation.

    >>> noise = Noise(seed=1, device="nose", sigma=0.01)
    >>> noise.at(0.25) == noise.at(0.25), noise.at(0.25) == noise.at(0.5)
    (True, False)
    """

    def __init__(self, seed: int, device: str, sigma: float) -> None:
        self._key = f"{seed}:{device}"
        self._sigma = sigma
        self._strip: NDArray[np.int16] = np.empty(0, dtype=np.int16)

    def at(self, time: float) -> float:
        """Return the error of a number captured at ``time``, by Box and Muller (1958)."""
        random = self._random_at(time)
        radius = math.sqrt(-2 * math.log(1 - random.random()))
        return self._sigma * radius * math.cos(math.tau * random.random())

    def over(self, shape: tuple[int, ...], time: float) -> NDArray[np.int16]:
        """Return the errors of a picture captured at ``time``, in whole grey levels whose deviation is ``sigma``.

        They are cut out of one long strip where the instant says: drawing them would take longer than painting.
        """
        size = math.prod(shape)
        if len(self._strip) < STRIP_STARTS + size:
            self._strip = self._drawn(STRIP_STARTS + size)
        start = int(STRIP_STARTS * self._random_at(time).random())
        return self._strip[start : start + size].reshape(shape)

    def _drawn(self, length: int) -> NDArray[np.int16]:
        """Return a strip of noise. ``RandomState`` is NumPy's one generator whose numbers never change."""
        generator = np.random.RandomState(Random(self._key).getrandbits(32))
        return np.rint(_before_rounding(self._sigma) * generator.standard_normal(length)).astype(np.int16)

    def _random_at(self, time: float) -> Random:
        return random_at(self._key, time)


def random_at(key: str, time: float) -> Random:
    """Return what draws for an instant, to the microsecond; the same for the same ``key``."""
    return Random(f"{key}:{round(1e6 * time)}")


def _before_rounding(sigma: float) -> float:
    """Return the deviation of the normal noise that has ``sigma`` once it is in whole numbers, by bisection.

    Rounding takes from a small deviation (0.2 becomes 0.11) and adds to others (1 becomes 1.04).
    """
    low, high = 0.0, sigma + 1
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if _rounded(middle) < sigma else (low, middle)
    return high


def _rounded(sigma: float) -> float:
    """Return the deviation of normal noise in whole numbers: k² - (k - 1)² counts for all from k - 1/2 on."""
    beyond = (math.erfc((k - 0.5) / (sigma * math.sqrt(2))) for k in range(1, math.ceil(8 * sigma) + 2))
    return math.sqrt(sum((2 * k - 1) * share for k, share in enumerate(beyond, start=1)))
