"""Rules for clocks, and for the time and sequence of samples."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robotcore.errors import UsageError
from robotcore.hal.backend import Capability
from robotcore.hal.devices import Battery
from robotcore.testing.bench import RATE_HZ, TestBench, list_sensors, sleep
from robotcore.testing.fakes import Gate

RATES_HZ = (10.0, 20.0, 30.0, 50.0)


class ClockRules(TestBench):
    """The rules for clocks."""

    def test_time_begins_at_zero(self) -> None:
        self.require(Capability.LOCKSTEP)
        with self.open_robot() as robot:
            assert (now := robot.clock.now()) == 0, f"just opened, the clock reads {now} s; count from the opening"

    def test_time_never_goes_back(self) -> None:
        with self.open_robot() as robot:
            times = [robot.clock.now()]
            for _ in range(5):
                robot.clock.sleep_until(times[-1] + 0.02)
                times.append(robot.clock.now())
        assert times == sorted(times), f"the clock went back: {times}"

    def test_sleep_does_not_end_before_its_deadline(self) -> None:
        with self.open_robot() as robot:
            deadline = robot.clock.now() + 0.1
            robot.clock.sleep_until(deadline)
            now = robot.clock.now()
        assert now >= deadline - 1e-9, f"sleep_until({deadline}) ended at {now}"

    @pytest.mark.parametrize("rate_hz", RATES_HZ)
    def test_steps_divide_the_tick(self, rate_hz: float) -> None:
        self.require(Capability.LOCKSTEP)
        try:
            robot = self.open(replace(self.build_setup(), rate_hz=rate_hz))
        except UsageError as refusal:
            pytest.skip(f"it refuses {rate_hz} Hz: {refusal}")
        with robot:
            for tick in range(1, 6):
                robot.clock.sleep_until(tick / rate_hz)
                assert robot.clock.now() == pytest.approx(tick / rate_hz, abs=1e-9), (
                    f"at {rate_hz} Hz, tick {tick} came at {robot.clock.now()} s instead of {tick / rate_hz} s; "
                    "the physics step must divide the tick, see SteppedClock"
                )

    def test_calls_are_made_when_they_are_due(self) -> None:
        called_at: list[float] = []
        with self.open_robot() as robot:
            due = robot.clock.now() + 0.1
            robot.clock.call_at(due, lambda: called_at.append(robot.clock.now()))
            robot.clock.sleep_until(due + 0.2)
        assert called_at, f"a call due at {due} s was never made, and time passed until {due + 0.2} s"
        assert due - 1e-9 <= called_at[0] < due + 0.1, f"a call due at {due} s was made at {called_at[0]} s"


FRESH_S = 1.0
"""The time in seconds within which a sensor must have a new sample. A battery has more time."""


class SampleRules(TestBench):
    """The rules for all sensors."""

    def test_capture_times_are_on_the_robots_clock(self) -> None:
        with self.open_robot() as robot:
            sleep(robot, FRESH_S)
            for sensor in list_sensors(robot):
                time, now = sensor.read().time, robot.clock.now()
                assert 0 <= time <= now, (
                    f"{sensor.name}: the capture time of a sample is {time} s, and robot.clock reads {now} s; "
                    "read the robot's clock at the capture"
                )

    def test_capture_time_advances(self) -> None:
        with self.open_robot() as robot:
            sensors = [sensor for sensor in list_sensors(robot) if not isinstance(sensor, Battery)]
            before = {sensor.name: sensor.read().time for sensor in sensors}
            sleep(robot, FRESH_S)
            for sensor in sensors:
                assert (time := sensor.read().time) > before[sensor.name], (
                    f"{sensor.name}: {FRESH_S} s later the newest sample is still of {time} s"
                )

    def test_new_sample_has_a_higher_sequence(self) -> None:
        with self.open_robot() as robot:
            before = {sensor.name: sensor.read() for sensor in list_sensors(robot)}
            sleep(robot, FRESH_S)
            for sensor in list_sensors(robot):
                old, new = before[sensor.name], sensor.read()
                assert new.time == old.time or new.sequence > old.sequence, (
                    f"{sensor.name}: the sample of {new.time} s has sequence {new.sequence}, the one of {old.time} s "
                    f"had {old.sequence}; count up with each new sample"
                )

    def test_sequence_changes_only_with_the_capture_time(self) -> None:
        with self.open_robot() as robot:
            for sensor in list_sensors(robot):
                first, second = sensor.read(), sensor.read()
                assert (first.sequence == second.sequence) == (first.time == second.time), (
                    f"{sensor.name}: read twice, it gave sequence {first.sequence} of {first.time} s, then "
                    f"{second.sequence} of {second.time} s; a sample has one time and one sequence"
                )

    def test_reading_does_not_advance_the_clock(self) -> None:
        self.require(Capability.LOCKSTEP)
        with self.open_robot() as robot:
            sleep(robot, 1 / RATE_HZ)
            for sensor in list_sensors(robot):
                before = robot.clock.now()
                sensor.read()
                assert (after := robot.clock.now()) == before, (
                    f"{sensor.name}: read() moved the clock from {before} s to {after} s; a stepped clock moves only "
                    "while a call sleeps"
                )

    def test_reading_does_not_wait_for_hardware(self) -> None:
        gate = Gate()
        with self.open_gated(self.build_setup(), gate) as robot:
            for sensor in list_sensors(robot):
                sensor.read()
                assert not gate.blocks(sensor.read), (
                    f"{sensor.name}: read() waited for the hardware's answer; poll the hardware in a thread of the "
                    "driver, and return the newest sample"
                )
