from __future__ import annotations

import math

import pytest

from drivers.kinematic.motion import Wheel
from robotcore.description import Start
from robotcore.geometry import Pose
from tests.drivers.kinematic.rooms import drive, get_truth, open_robot, room, sleep

COASTING_S = 3.0


def drive_to_pose(linear: float, angular: float, seconds: float, rate_hz: float = 20.0) -> Pose:
    with open_robot(rate_hz=rate_hz) as robot:
        drive(robot, linear, angular, seconds)
        sleep(robot, COASTING_S)
        return get_truth(robot).pose()


@pytest.mark.parametrize("rate_hz", [20.0, 50.0, 7.0])
def test_an_arc_follows_the_circle_at_every_rate(rate_hz: float) -> None:
    linear, angular, seconds = 0.15, 0.6, 5.0
    radius, turn = linear / angular, angular * seconds
    circle = (radius * math.sin(turn), radius * (1 - math.cos(turn)), turn)
    assert drive_to_pose(linear, angular, seconds, rate_hz) == pytest.approx(circle, abs=1e-9)


def test_velocity_follows_the_first_order_lag() -> None:
    wheel = Wheel(lag=0.05, step=1 / 240)
    wheel.target = 6.0
    for _ in range(24):
        wheel.advance()
    assert wheel.velocity == pytest.approx(6.0 * (1 - math.exp(-2)), abs=1e-12)
    assert wheel.angle == pytest.approx(6.0 * (0.1 - 0.05 * (1 - math.exp(-2))), abs=1e-12)


def test_wheel_without_a_lag_has_its_velocity_in_its_first_step() -> None:
    wheel = Wheel(lag=0.0, step=0.5)
    for target, angle in ((4.0, 2.0), (-1.0, 1.5)):
        wheel.target = target
        wheel.advance()
        assert (wheel.velocity, wheel.angle) == (target, angle)


def test_twist_includes_the_lag() -> None:
    with open_robot() as robot:
        for motor in robot.motors.values():
            motor.set_velocity(6.0)
        sleep(robot, 0.05)
        twist = get_truth(robot).twist()
    assert twist == pytest.approx((6.0 * 0.0325 * (1 - math.exp(-1)), 0.0))


def test_robot_starts_at_the_start_of_the_world() -> None:
    with open_robot(room(start=Start(x_m=0.5, y_m=-0.25, yaw_rad=2.0))) as robot:
        assert get_truth(robot).pose() == (0.5, -0.25, 2.0)
