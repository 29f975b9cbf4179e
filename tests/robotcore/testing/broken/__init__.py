"""Deliberately broken drivers, a file for each kind of device."""

from tests.robotcore.testing.broken import (
    batteries,
    cameras,
    clocks,
    displays,
    encoders,
    lifecycles,
    motors,
    ranges,
    samples,
    truths,
)
from tests.robotcore.testing.harness import Broken

BROKEN: tuple[Broken, ...] = (
    *motors.BROKEN,
    *encoders.BROKEN,
    *ranges.BROKEN,
    *cameras.BROKEN,
    *batteries.BROKEN,
    *samples.BROKEN,
    *displays.BROKEN,
    *clocks.BROKEN,
    *truths.BROKEN,
    *lifecycles.BROKEN,
)
