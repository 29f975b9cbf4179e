"""Broken drivers, one module for each kind of device."""

from tests.robotcore.testing.broken import (
    cameras,
    cutoffs,
    devices,
    kinds,
    lifecycles,
    motors,
    ranges,
    times,
    truths,
    unmeasured,
    unplugged,
)
from tests.robotcore.testing.harness import Broken

BROKEN: tuple[Broken, ...] = (
    *motors.BROKEN,
    *cutoffs.BROKEN,
    *unmeasured.BROKEN,
    *devices.BROKEN,
    *kinds.BROKEN,
    *ranges.BROKEN,
    *cameras.BROKEN,
    *times.BROKEN,
    *truths.BROKEN,
    *lifecycles.BROKEN,
    *unplugged.BROKEN,
)
