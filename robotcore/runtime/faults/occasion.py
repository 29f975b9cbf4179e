"""The run in which a fault happens: its clock, and its chance."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from robotcore.hal.clock import Clock
from robotcore.runtime.layers.noise import Noise, random_at


@dataclass(frozen=True)
class Occasion:
    """One fault of a run, as it was ``written``; ``position`` tells it from the run's other faults.

    What is drawn belongs to the seed, the fault, the device and the instant: it comes out the same in every run, and
    reading more or less often changes nothing.
    """

    clock: Clock
    seed: int
    position: int
    written: str

    def random_at(self, device: str, time: float) -> Random:
        """Return what draws for a device at an instant."""
        return random_at(f"{self.seed}:{self._source(device)}", time)

    def noise(self, device: str, sigma: float) -> Noise:
        """Return normal noise of a device; ``sigma`` is its deviation."""
        return Noise(self.seed, self._source(device), sigma)

    def _source(self, device: str) -> str:
        return f"{device}:fault {self.position}"
