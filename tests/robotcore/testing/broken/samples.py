from __future__ import annotations

import itertools
from dataclasses import replace

from robotcore.hal.backend import Setup
from robotcore.hal.devices import Range, RangeSensor, Sensor
from robotcore.hal.robot import Robot
from robotcore.testing import Gate
from tests.robotcore.testing.broken.sensing import saying
from tests.robotcore.testing.harness import Broken, Sound, broken

EPOCH_S = 1.7e9


def counting_reads(robot: Robot) -> None:
    numbers = itertools.count()
    saying(RangeSensor, lambda sample: replace(sample, sequence=next(numbers)))(robot)


def sleeping(robot: Robot) -> None:
    def sleep(sample: Range) -> Range:
        robot.clock.sleep_until(robot.clock.now() + 0.005)
        return sample

    saying(RangeSensor, sleep)(robot)


class Unlayered(Sensor[Range]):
    """A range sensor that is none by its class."""

    def __init__(self, inner: RangeSensor) -> None:
        super().__init__(inner.name)
        self._inner = inner

    def _newest(self) -> Range:
        return replace(self._inner.read())


def of_an_unknown_kind(robot: Robot) -> None:
    if "nose" in robot.devices:
        robot.devices["nose"] = Unlayered(robot.range)


class WaitsForHardware(Sound):
    """Asks the hardware when it is read."""

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        robot = self.open(setup)
        saying(RangeSensor, lambda sample: _after(gate, sample))(robot)
        return robot


def _after(gate: Gate, sample: Range) -> Range:
    gate.pass_through()
    return sample


BROKEN = (
    broken(
        "capture times are those of the machine",
        "capture_times_are_on_the_robots_clock",
        saying(RangeSensor, lambda sample: replace(sample, time=sample.time + EPOCH_S)),
    ),
    broken(
        "the capture time is that of the first sample",
        "capture_time_advances",
        saying(RangeSensor, lambda sample: replace(sample, time=0.0)),
    ),
    broken(
        "every sample has the same sequence",
        "new_sample_has_a_higher_sequence",
        saying(RangeSensor, lambda sample: replace(sample, sequence=0)),
    ),
    broken("the sequence counts reads", "sample_read_twice_is_the_same", counting_reads),
    broken("reading lets time pass", "reading_lets_no_time_pass", sleeping),
    broken(
        "a sensor is of no kind that the layers know", "within_a_tick_a_device_gives_one_sample", of_an_unknown_kind
    ),
    Broken("reading asks the hardware", frozenset({"reading_does_not_wait_for_hardware"}), WaitsForHardware),
)
