"""Random numbers for simulated noise. A key and a time determine each number, so that equal runs have equal noise."""

from __future__ import annotations

import math
from random import Random

import numpy as np
from numpy.typing import NDArray


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
