from __future__ import annotations

import itertools
import math
import time
from dataclasses import replace
from functools import partial

from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.range_sensor import Range, RangeSensor
from robotcore.testing import Gate
from tests.robotcore.testing.broken.motors import Apply, change_apply
from tests.robotcore.testing.broken.sensing import change_samples
from tests.robotcore.testing.harness import Sound, broken, replace_attribute

EPOCH_S = 1.7e9


def count_reads(robot: Robot) -> None:
    numbers = itertools.count()
    change_samples(RangeSensor, lambda sample: replace(sample, sequence=next(numbers)))(robot)


def sleep_in_reads(robot: Robot) -> None:
    def sleep(sample: Range) -> Range:
        robot.clock.sleep_until(robot.clock.now() + 0.005)
        return sample

    change_samples(RangeSensor, sleep)(robot)


class HardwareWaitSuite(Sound):
    """A suite for a driver whose sensors wait for the hardware in ``read``."""

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        robot = self.open(setup)
        change_samples(RangeSensor, lambda sample: _wait_at(gate, sample))(robot)
        return robot


def _wait_at(gate: Gate, sample: Range) -> Range:
    gate.pass_through()
    return sample


class SlowReadSuite(Sound):
    """A suite for a driver whose sensors return a sample late, without an answer of the hardware."""

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        robot = self.open(setup)
        change_samples(RangeSensor, _return_late)(robot)
        return robot


def _return_late(sample: Range) -> Range:
    time.sleep(0.03)
    return sample


class MotorWaitSuite(Sound):
    """A suite for a driver whose motors take one command at once, and wait for the hardware with the next."""

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        robot = self.open(setup)
        change_apply(partial(_wait_from_second, gate))(robot)
        return robot


def _wait_from_second(gate: Gate, apply: Apply) -> Apply:
    commands = itertools.count()

    def send(rad_s: float) -> None:
        if next(commands):
            gate.pass_through()
        apply(rad_s)

    return send


class SlowCommandSuite(Sound):
    """A suite for a driver whose motors take a command late, without an answer of the hardware."""

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        robot = self.open(setup)
        change_apply(_sleep_first)(robot)
        return robot


def _sleep_first(apply: Apply) -> Apply:
    def send(rad_s: float) -> None:
        time.sleep(0.03)
        apply(rad_s)

    return send


def sleep_one_step(robot: Robot) -> None:
    robot.clock.sleep_until(1 / 240)


def end_sleeps_early(robot: Robot) -> None:
    sleep_until = robot.clock.sleep_until
    replace_attribute(robot.clock, "sleep_until", lambda deadline: sleep_until(deadline - 0.005))


def set_back(robot: Robot) -> None:
    """Set the clock back by a second after the fourth sleep."""
    now, sleep_until = robot.clock.now, robot.clock.sleep_until
    sleeps: list[float] = []

    def sleep(deadline: float) -> bool:
        sleeps.append(deadline)
        return sleep_until(deadline)

    replace_attribute(robot.clock, "sleep_until", sleep)
    replace_attribute(robot.clock, "now", lambda: now() - (1.0 if len(sleeps) == 4 else 0.0))


def drop_calls(robot: Robot) -> None:
    replace_attribute(robot.clock, "call_at", lambda deadline, callback: None)


BROKEN = (
    broken("a command waits for the hardware", "command_does_not_wait_for_hardware", suite=MotorWaitSuite),
    broken("a command takes 30 ms", "command_does_not_wait_for_hardware", suite=SlowCommandSuite),
    broken(
        "capture times are those of the machine",
        "capture_times_are_on_the_robots_clock",
        change_samples(RangeSensor, lambda sample: replace(sample, time=sample.time + EPOCH_S)),
    ),
    broken(
        "the capture time is that of the first sample",
        "capture_time_advances sequence_changes_only_with_the_capture_time",
        change_samples(RangeSensor, lambda sample: replace(sample, time=0.0)),
    ),
    broken(
        "every sample has the same sequence",
        "new_sample_has_a_higher_sequence sequence_changes_only_with_the_capture_time",
        change_samples(RangeSensor, lambda sample: replace(sample, sequence=0)),
    ),
    broken("the sequence counts reads", "sequence_changes_only_with_the_capture_time", count_reads),
    broken(
        "the capture time is that of the reading",
        "sequence_changes_only_with_the_capture_time",
        change_samples(RangeSensor, lambda sample: replace(sample, sequence=math.floor(sample.time / 0.05))),
    ),
    broken("reading lets time pass", "reading_does_not_advance_the_clock", sleep_in_reads),
    broken("reading asks the hardware", "reading_does_not_wait_for_hardware", suite=HardwareWaitSuite),
    broken("reading takes 30 ms", "reading_does_not_wait_for_hardware", suite=SlowReadSuite),
    broken("time begins before the opening", "time_begins_at_zero", sleep_one_step),
    broken(
        "the clock is set back",
        "time_never_goes_back steps_divide_the_tick wheels_turn_at_the_commanded_velocity",
        set_back,
    ),
    broken(
        "sleep ends early",
        "sleep_does_not_end_before_its_deadline steps_divide_the_tick",
        end_sleeps_early,
    ),
    broken(
        "the physics step is 1/240 s at every rate",
        "steps_divide_the_tick",
        change_setup=lambda setup: replace(setup, rate_hz=20.0),
    ),
    broken("calls are forgotten", "calls_are_made_when_they_are_due", drop_calls),
)
