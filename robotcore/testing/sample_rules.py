"""Rules for all samples: when they were captured, which one they are, and that reading takes no time."""

from __future__ import annotations

from robotcore.hal.backend import Vouch
from robotcore.hal.devices import Battery
from robotcore.testing.bench import RATE_HZ, Bench, let_pass, sensors_of
from robotcore.testing.gate import Gate

FRESH_S = 1.0
"""Every sensor has something new within this time, but for a battery."""


class SampleRules(Bench):
    """What every sensor owes, whatever it reads."""

    def test_capture_times_are_on_the_robots_clock(self) -> None:
        with self.opened() as robot:
            let_pass(robot, FRESH_S)
            for sensor in sensors_of(robot):
                time, now = sensor.read().time, robot.clock.now()
                assert 0 <= time <= now, (
                    f"{sensor.name}: a sample says it was captured at {time} s while robot.clock says {now} s; "
                    "take the time from the robot's clock, at the capture"
                )

    def test_capture_time_advances(self) -> None:
        with self.opened() as robot:
            sensors = [sensor for sensor in sensors_of(robot) if not isinstance(sensor, Battery)]
            before = {sensor.name: sensor.read().time for sensor in sensors}
            let_pass(robot, FRESH_S)
            for sensor in sensors:
                assert (time := sensor.read().time) > before[sensor.name], (
                    f"{sensor.name}: {FRESH_S} s later the newest sample is still of {time} s"
                )

    def test_new_sample_has_a_higher_sequence(self) -> None:
        with self.opened() as robot:
            before = {sensor.name: sensor.read() for sensor in sensors_of(robot)}
            let_pass(robot, FRESH_S)
            for sensor in sensors_of(robot):
                old, new = before[sensor.name], sensor.read()
                assert new.time == old.time or new.sequence > old.sequence, (
                    f"{sensor.name}: the sample of {new.time} s has sequence {new.sequence}, the one of {old.time} s "
                    f"had {old.sequence}; it counts up with each new sample"
                )

    def test_sample_read_twice_is_the_same(self) -> None:
        with self.opened() as robot:
            for sensor in sensors_of(robot):
                first, second = sensor.read(), sensor.read()
                assert (first.sequence == second.sequence) == (first.time == second.time), (
                    f"{sensor.name}: read twice, it gave sequence {first.sequence} of {first.time} s, then "
                    f"{second.sequence} of {second.time} s; a sample has one time and one sequence"
                )

    def test_reading_lets_no_time_pass(self) -> None:
        self.require(Vouch.LOCKSTEP)
        with self.opened() as robot:
            let_pass(robot, 1 / RATE_HZ)
            for sensor in sensors_of(robot):
                before = robot.clock.now()
                sensor.read()
                assert (after := robot.clock.now()) == before, (
                    f"{sensor.name}: read() moved the clock from {before} s to {after} s; a stepped clock moves only "
                    "while somebody sleeps"
                )

    def test_reading_does_not_wait_for_hardware(self) -> None:
        gate = Gate()
        with self.open_gated(self.setup_for(), gate) as robot:
            for sensor in sensors_of(robot):
                sensor.read()
                assert not gate.holds_up(sensor.read), (
                    f"{sensor.name}: read() waited for the hardware's answer; poll the hardware in a thread of the "
                    "driver's own and hand out the newest sample"
                )
