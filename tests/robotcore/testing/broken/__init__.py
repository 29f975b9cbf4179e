"""Broken drivers, one module for each kind of device."""

from tests.robotcore.testing.broken import cameras, devices, lifecycles, motors, ranges, times, truths, unmeasured
from tests.robotcore.testing.harness import Broken

BROKEN: tuple[Broken, ...] = (
    *motors.BROKEN,
    *unmeasured.BROKEN,
    *devices.BROKEN_ENCODERS,
    *ranges.BROKEN,
    *cameras.BROKEN,
    *devices.BROKEN_BATTERIES,
    *times.BROKEN_MOTOR_WAITS,
    *times.BROKEN_SAMPLES,
    *devices.BROKEN_DISPLAYS,
    *times.BROKEN_CLOCKS,
    *truths.BROKEN,
    *lifecycles.BROKEN,
)
