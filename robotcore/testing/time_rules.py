"""Rules for clocks, and for the time and sequence of samples."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robotcore.errors import UsageError
from robotcore.hal.backend import Capability
from robotcore.hal.robot import Robot
from robotcore.testing.bench import (
    MAX_CALL_S,
    RATE_HZ,
    UNPLUGGED_S,
    TestBench,
    list_sensors,
    measure_time,
    raises_in_time,
    sleep,
)
from robotcore.testing.fakes import Gate

RATES_HZ = (10.0, 20.0, 30.0, 50.0)

ATTEMPTS = 5
"""The number of calls of which one must be made in time. On a busy machine, a clock in real time may be late."""


class ClockRules(TestBench):
    """Rules for a robot's clock."""

    def test_time_begins_at_zero(self) -> None:
        self.require(Capability.LOCKSTEP)
        with self.open_robot() as robot:
            assert (now := robot.clock.now()) == 0, (
                f"the clock of a robot that was just opened returned {now} s. Count the time from the opening"
            )

    def test_time_never_goes_back(self) -> None:
        with self.open_robot() as robot:
            times = [robot.clock.now()]
            for _ in range(5):
                robot.clock.sleep_until(times[-1] + 0.02)
                times.append(robot.clock.now())
        assert times == sorted(times), f"the clock went back: {times}. Let now() never decrease"

    def test_sleep_does_not_end_before_its_deadline(self) -> None:
        with self.open_robot() as robot:
            deadline = robot.clock.now() + 0.1
            robot.clock.sleep_until(deadline)
            now = robot.clock.now()
        assert now >= deadline - 1e-9, f"sleep_until({deadline}) ended at {now} s. Do not return before the deadline"

    @pytest.mark.parametrize("rate_hz", RATES_HZ)
    def test_steps_divide_the_tick(self, rate_hz: float) -> None:
        self.require(Capability.LOCKSTEP)
        setup = replace(self.build_setup(), rate_hz=rate_hz)
        try:
            robot = self.open(setup)
        except UsageError as refusal:
            pytest.skip(f"the backend does not support {rate_hz} Hz: {refusal}")
        with robot:
            for tick in range(1, 6):
                robot.clock.sleep_until(tick / rate_hz)
                assert robot.clock.now() == pytest.approx(tick / rate_hz, abs=1e-9), (
                    f"at {rate_hz} Hz tick {tick} began at {robot.clock.now()} s instead of {tick / rate_hz} s. "
                    "Use SteppedClock, whose physics step divides a tick exactly"
                )

    def test_calls_are_made_when_they_are_due(self) -> None:
        delays: list[float] = []
        with self.open_robot() as robot:
            while not delays or (delays[-1] >= 0.1 and len(delays) < ATTEMPTS):
                delays.append(self._measure_call_delay(robot))
        assert min(delays) >= -1e-9, f"the clock made a call {-min(delays)} s before it was due. Never make it earlier"
        assert min(delays) < 0.1, (
            f"the clock made the calls {delays} s after they were due. Make each within 0.1 s after it is due"
        )

    @staticmethod
    def _measure_call_delay(robot: Robot) -> float:
        called_at: list[float] = []
        due = robot.clock.now() + 0.1
        robot.clock.call_at(due, lambda: called_at.append(robot.clock.now()))
        robot.clock.sleep_until(due + 0.2)
        assert called_at, (
            f"the clock had not made the call due at {due} s by {due + 0.2} s. Make due calls in sleep_until()"
        )
        return called_at[0] - due


FRESH_S = 1.0
"""A sensor must have a new sample within this time, in seconds."""

MONITORED_FRESH_S = 5.0
"""A monitored sensor, such as a battery, must have a new sample within this time, in seconds."""


PAUSES_S = (0.0, 0.005, 0.005, 0.005)
"""The pauses between readings of one sensor, in seconds. Most drivers poll less often."""


class SampleRules(TestBench):
    """Rules for the samples of every sensor."""

    def test_capture_times_are_on_the_robots_clock(self) -> None:
        with self.open_robot() as robot:
            sleep(robot, FRESH_S)
            for sensor in list_sensors(robot):
                time, now = sensor.read().time, robot.clock.now()
                assert 0 <= time <= now, (
                    f"{sensor.name} returned a sample with the capture time {time} s at {now} s of the robot's clock. "
                    "Read the robot's clock at the capture"
                )

    def test_capture_time_advances(self) -> None:
        with self.open_robot() as robot:
            sensors = sorted(list_sensors(robot), key=lambda sensor: sensor.is_monitored)
            before = {sensor.name: sensor.read().time for sensor in sensors}
            slept_s = 0.0
            for sensor in sensors:
                fresh_s = MONITORED_FRESH_S if sensor.is_monitored else FRESH_S
                if slept_s < fresh_s:
                    sleep(robot, fresh_s - slept_s)
                    slept_s = fresh_s
                assert (time := sensor.read().time) > before[sensor.name], (
                    f"{sensor.name}: after {fresh_s:g} s the newest sample is still the one of {time} s. "
                    f"Take a new sample at least every {fresh_s:g} s"
                )

    def test_new_sample_has_a_higher_sequence(self) -> None:
        with self.open_robot() as robot:
            before = {sensor.name: sensor.read() for sensor in list_sensors(robot)}
            sleep(robot, FRESH_S)
            for sensor in list_sensors(robot):
                old, new = before[sensor.name], sensor.read()
                assert new.time == old.time or new.sequence > old.sequence, (
                    f"{sensor.name} returned sequence {new.sequence} for the sample of {new.time} s, after "
                    f"{old.sequence} for the sample of {old.time} s. Increase it with each new sample"
                )

    def test_sequence_changes_only_with_the_capture_time(self) -> None:
        with self.open_robot() as robot:
            for sensor in list_sensors(robot):
                first = sensor.read()
                for pause_s in PAUSES_S:
                    sleep(robot, pause_s)
                    second = sensor.read()
                    assert (first.sequence == second.sequence) == (first.time == second.time), (
                        f"{sensor.name} returned sequence {first.sequence} with {first.time} s, then "
                        f"{second.sequence} with {second.time} s. Change sequence and time together, at each new sample"
                    )
                    first = second

    def test_reading_does_not_advance_the_clock(self) -> None:
        self.require(Capability.LOCKSTEP)
        with self.open_robot() as robot:
            sleep(robot, 1 / RATE_HZ)
            for sensor in list_sensors(robot):
                before = robot.clock.now()
                sensor.read()
                assert (after := robot.clock.now()) == before, (
                    f"{sensor.name}: read() advanced the clock from {before} s to {after} s. Advance a stepped clock "
                    "only in sleep_until()"
                )

    def test_reading_does_not_wait_for_hardware(self) -> None:
        gate = Gate()
        with self.open_gated(self.build_setup(), gate) as robot:
            for sensor in list_sensors(robot):
                sensor.read()
                assert not gate.blocks(sensor.read), (
                    f"{sensor.name}: read() waited for the hardware. Poll the hardware in a thread of the driver, and "
                    "let read() return the newest sample"
                )
                fastest_s = min(measure_time(sensor.read) for _ in range(3))
                assert fastest_s < MAX_CALL_S, (
                    f"{sensor.name}: read() took {1000 * fastest_s:.0f} ms, which delays every tick. Return the newest "
                    f"sample within {1000 * MAX_CALL_S:.0f} ms, and measure in a thread of the driver"
                )

    def test_reading_unplugged_hardware_is_an_error(self) -> None:
        with self.open_unplugged() as robot:
            for sensor in list_sensors(robot):
                assert raises_in_time(robot, sensor.read), (
                    f"{sensor.name}: read() raised no error in {UNPLUGGED_S:g} s without hardware. Raise the error of "
                    "the last poll in read(), as DeviceError"
                )
