"""Noise that belongs to the instant, not to the reading: reading more or less often changes nothing."""

from __future__ import annotations

from zlib import crc32

import numpy as np
from numpy.random import PCG64, Generator, SeedSequence

from robotcore.devices import Image


class Noise:
    """Normal noise of one device, drawn for each physics step by itself from the run's seed.

    >>> noise = Noise(seed=1, device="nose", sigma=0.01)
    >>> noise.error(step=7) == noise.error(step=7)
    True
    """

    def __init__(self, seed: int, device: str, sigma: float) -> None:
        self._sigma = sigma
        self._key = (abs(seed), int(seed < 0), crc32(device.encode()))

    def error(self, step: int) -> float:
        """Return the error of a number captured at ``step``."""
        return self._sigma * self._generator(step).standard_normal() if self._sigma else 0.0

    def over(self, image: Image, step: int) -> Image:
        """Return a picture captured at ``step`` with its noise; the picture itself where there is none."""
        if not self._sigma:
            return image
        noise = self._generator(step).standard_normal(image.shape, dtype=np.float32) * np.float32(self._sigma)
        return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)

    def _generator(self, step: int) -> Generator:
        return Generator(PCG64(SeedSequence((*self._key, step))))
