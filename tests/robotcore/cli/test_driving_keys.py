"""The keys of a terminal drive a robot, and the robot stands soon after the last key."""

from __future__ import annotations

import pytest

from robotcore.cli.driving_keys import FIRST_S, REPEAT_S, TAP_SCALE, TURN_SCALE, UPDATE_S, DrivingKeys
from robotcore.hal.clock import SteppedClock
from robotcore.hal.drive import DifferentialDrive
from robotcore.runtime.operator_input import LEASE_S, OperatorInput
from robotcore.testing import MockRobot


class Person:
    """Types keys while time passes in steps of `UPDATE_S`."""

    def __init__(self, robot: str = "rover") -> None:
        self.clock = SteppedClock(1 / UPDATE_S, lambda steps: None)
        self.operator = OperatorInput(clock=self.clock)
        self.drive: DifferentialDrive = MockRobot(robot).layered.drive
        self.keys = DrivingKeys(self.operator, self.drive, self.clock)

    def type(self, keys: bytes) -> None:
        self.keys.press(keys)

    def wait(self, seconds: float) -> None:
        end = self.clock.now() + seconds
        while self.clock.now() + UPDATE_S / 2 < end:
            self.clock.sleep_until(self.clock.now() + UPDATE_S)
            self.keys.update()

    def hold(self, key: bytes, seconds: float, delay_s: float = 0.5, interval_s: float = 0.05) -> None:
        self.type(key)
        self.wait(min(seconds, delay_s))
        for _ in range(round((seconds - delay_s) / interval_s)):
            self.type(key)
            self.wait(interval_s)

    @property
    def velocity(self) -> tuple[float, float]:
        """The velocity as ratios to the greatest velocities of the drive."""
        sample = self.operator.read(0.0, 0)
        assert not sample.is_silent
        return sample.linear / self.drive.max_linear, sample.angular / self.drive.max_angular


def test_a_tap_is_a_slow_step() -> None:
    person = Person()
    person.type(b"w")
    person.wait(FIRST_S - UPDATE_S)
    assert person.velocity == pytest.approx((0.5 * TAP_SCALE, 0.0))
    person.wait(2 * UPDATE_S)
    assert person.velocity == (0.0, 0.0)


@pytest.mark.parametrize("delay_s", [0.25, 0.5, 0.6])
def test_a_held_key_drives_without_a_gap_and_the_robot_stands_soon_after_its_release(delay_s: float) -> None:
    person = Person()
    person.type(b"w")
    for _ in range(round(delay_s / UPDATE_S)):
        assert person.velocity[0] > 0
        person.wait(UPDATE_S)
    assert person.velocity[0] > 0
    for _ in range(20):
        person.type(b"w")
        person.wait(0.1)
        assert person.velocity == pytest.approx((0.5, 0.0))
    person.wait(max(REPEAT_S, FIRST_S - delay_s - 2.0))
    assert person.velocity == (0.0, 0.0)


@pytest.mark.parametrize(
    "key, linear, angular",
    [
        (b"w", 1, 0),
        (b"\x1b[A", 1, 0),
        (b"\x1bOA", 1, 0),
        (b"\x1b[1;2A", 1, 0),
        (b"S", -1, 0),
        (b"\x1b[B", -1, 0),
        (b"a", 0, 1),
        (b"\x1b[D", 0, 1),
        (b"d", 0, -1),
        (b"\x1b[C", 0, -1),
        (b"q", 1, 0.5),
        (b"e", 1, -0.5),
    ],
)
def test_each_key_has_its_direction(key: bytes, linear: float, angular: float) -> None:
    person = Person()
    person.hold(key, 1.0)
    assert person.velocity == pytest.approx((0.5 * linear, 0.5 * TURN_SCALE * angular))


def test_an_arrow_key_may_arrive_in_parts() -> None:
    person = Person()
    for part in (b"\x1b", b"[", b"D"):
        person.type(part)
    assert person.velocity[1] > 0


def test_an_escape_key_alone_and_other_sequences_do_nothing() -> None:
    person = Person()
    person.type(b"\x1b")
    person.type(b"\x1b[5~\x1bOP")
    assert not person.operator.is_driving
    person.type(b"w")
    assert person.velocity[0] > 0


def test_a_letter_with_alt_does_nothing() -> None:
    person = Person()
    person.type(b"\x1bd\x1bw")
    assert not person.operator.is_driving


def test_plus_and_minus_change_the_speed_limit_within_its_bounds() -> None:
    person = Person()
    person.type(b"+" * 20)
    person.hold(b"w", 1.0)
    assert person.velocity[0] == pytest.approx(1.0)
    person.type(b"-" * 20)
    assert person.velocity[0] == pytest.approx(0.1)
    assert "speed 10%" in person.keys.hint


def test_x_lets_the_robot_stand_at_once_and_the_person_keeps_it() -> None:
    person = Person()
    person.hold(b"w", 1.0)
    person.type(b"x")
    assert person.velocity == (0.0, 0.0)
    assert person.operator.is_driving


def test_r_returns_the_robot_to_the_app_and_no_update_takes_it_again() -> None:
    person = Person()
    person.hold(b"w", 1.0)
    person.type(b"r")
    person.wait(1.0)
    assert not person.operator.is_driving
    assert "WASD" in person.keys.hint


def test_the_person_is_not_silent_while_the_keys_are_updated_and_is_without_updates() -> None:
    person = Person()
    person.type(b"w")
    person.wait(3.0)
    assert person.velocity == (0.0, 0.0)
    person.clock.sleep_until(person.clock.now() + LEASE_S + UPDATE_S)
    assert person.operator.read(0.0, 0).is_silent


def test_a_robot_that_steers_drives_its_sharpest_turn() -> None:
    person = Person("picar")
    person.hold(b"a", 1.0)
    sample = person.operator.read(0.0, 0)
    assert sample.linear == pytest.approx(0.5 * person.drive.max_linear)
    assert sample.linear / sample.angular == pytest.approx(person.drive.min_turn_radius)


def test_a_suspension_lets_the_robot_stand() -> None:
    person = Person()
    person.hold(b"w", 1.0)
    person.keys.stand()
    assert person.velocity == (0.0, 0.0)
    person.wait(UPDATE_S)
    assert person.velocity == (0.0, 0.0)


def test_the_keys_yield_to_another_sender_until_the_next_key() -> None:
    person = Person()
    person.hold(b"w", 1.0)
    person.operator.drive(0.0, 1.0)
    person.keys.update()
    assert person.operator.read(0.0, 0).angular == 1.0
    person.operator.release()
    person.wait(1.0)
    assert not person.operator.is_driving
    person.type(b"w")
    person.wait(UPDATE_S)
    assert person.velocity[0] > 0
