from __future__ import annotations

import math

import pytest

from drivers.kinematic.motion import Wheel
from robotcore.description import Start
from robotcore.geometry import Pose
from tests.drivers.kinematic.rooms import drive, let_pass, opened, room, rover_with, truth_of

COASTING_S = 3.0


def pose_after(linear: float, angular: float, seconds: float, rate_hz: float = 20.0) -> Pose:
    with opened(rate_hz=rate_hz) as robot:
        drive(robot, linear, angular, seconds)
        let_pass(robot, COASTING_S)
        return truth_of(robot).pose()


def test_a_metre_straight_ahead_is_a_metre() -> None:
    assert pose_after(0.2, 0.0, 5.0) == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)


def test_a_full_turn_on_the_spot_stays_on_the_spot() -> None:
    assert pose_after(0.0, math.tau / 4, 4.0) == pytest.approx((0.0, 0.0, math.tau), abs=1e-9)


@pytest.mark.parametrize("rate_hz", [20.0, 50.0, 7.0])
def test_an_arc_follows_the_circle_at_every_rate(rate_hz: float) -> None:
    linear, angular, seconds = 0.15, 0.6, 5.0
    radius, turn = linear / angular, angular * seconds
    circle = (radius * math.sin(turn), radius * (1 - math.cos(turn)), turn)
    assert pose_after(linear, angular, seconds, rate_hz) == pytest.approx(circle, abs=1e-9)


def test_when_the_command_ends_the_lag_has_cost_its_own_length() -> None:
    with opened() as robot:
        drive(robot, 0.2, 0.0, 5.0)
        assert truth_of(robot).pose().x == pytest.approx(1.0 - 0.2 * 0.05, abs=1e-9)


def test_velocity_rises_as_the_first_order_lag_says() -> None:
    wheel = Wheel(lag=0.05, step=1 / 240)
    wheel.target = 6.0
    for _ in range(24):
        wheel.advance()
    assert wheel.velocity == pytest.approx(6.0 * (1 - math.exp(-2)), abs=1e-12)
    assert wheel.angle == pytest.approx(6.0 * (0.1 - 0.05 * (1 - math.exp(-2))), abs=1e-12)


def test_without_a_lag_velocity_is_there_at_once() -> None:
    with opened(robot=rover_with(lag_s=0.0)) as robot:
        drive(robot, 0.3, 0.0, 1.0)
        assert truth_of(robot).pose().x == pytest.approx(0.3, abs=1e-9)
        assert truth_of(robot).twist() == pytest.approx((0.3, 0.0))
        let_pass(robot, 1.0)
        assert truth_of(robot).pose().x == pytest.approx(0.3, abs=1e-9)


def test_a_wheel_without_a_lag_turns_as_reported_in_its_first_step() -> None:
    wheel = Wheel(lag=0.0, step=0.5)
    for target, angle in ((4.0, 2.0), (-1.0, 1.5)):
        wheel.target = target
        wheel.advance()
        assert (wheel.velocity, wheel.angle) == (target, angle)


def test_twist_is_that_of_the_body_not_of_the_command() -> None:
    with opened() as robot:
        for motor in robot.motors.values():
            motor.set_velocity(6.0)
        let_pass(robot, 0.05)
        twist = truth_of(robot).twist()
    assert twist == pytest.approx((6.0 * 0.0325 * (1 - math.exp(-1)), 0.0))


def test_how_a_sleep_is_cut_does_not_matter() -> None:
    poses = []
    for naps in (1, 40):
        with opened() as robot:
            for motor, velocity in zip(robot.motors.values(), (3.0, 5.0), strict=True):
                motor.set_velocity(velocity)
            for _ in range(naps):
                let_pass(robot, 2.0 / naps)
            poses.append(truth_of(robot).pose())
    assert poses[0] == poses[1]


def test_the_start_pose_is_the_worlds() -> None:
    with opened(room(start=Start(x_m=0.5, y_m=-0.25, yaw_rad=2.0))) as robot:
        assert truth_of(robot).pose() == (0.5, -0.25, 2.0)
