from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from robotcore.errors import DeviceClosedError, InvalidCommandError
from tests.robotcore.fakes import UNHURRIED, Rig


@pytest.fixture
def rig() -> Rig:
    return Rig(description=UNHURRIED)


def test_commands_of_single_motors_are_sent_together(rig: Rig) -> None:
    left, right = rig.robot.motors.values()
    assert left.set_velocity(1.0) == 1.0
    assert right.set_velocity(2.0) == 2.0
    assert rig.left.sent == []
    rig.commit()
    assert rig.wheels == (1.0, 2.0)


def test_later_change_of_an_array_does_not_change_a_command(rig: Rig) -> None:
    speeds: Any = np.array([1.0, 2.0])
    left, right = rig.robot.motors.values()
    left.set_velocity(speeds[0, ...])
    right.set_velocity(speeds[1, ...])
    speeds *= 500
    rig.commit()
    assert rig.wheels == (1.0, 2.0)


def test_wheel_without_a_command_keeps_its_velocity(rig: Rig) -> None:
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    rig.robot.motors["left_motor"].set_velocity(3.0)
    rig.commit()
    assert rig.wheels == (3.0, 2.0)


def test_limit_of_one_wheel_slows_the_other_in_proportion(rig: Rig) -> None:
    left, right = rig.robot.motors.values()
    left.set_velocity(6.0)
    assert right.set_velocity(24.0) == 12.0
    rig.commit()
    assert rig.wheels == (3.0, 12.0)


def test_stop_of_one_wheel_stops_the_robot_at_once(rig: Rig) -> None:
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    rig.robot.motors["left_motor"].stop()
    assert rig.wheels == (0.0, 0.0)


def test_range_guard_limits_commands_of_single_motors(rig: Rig) -> None:
    rig.nose.distance = 0.05
    left, right = rig.robot.motors.values()
    left.set_velocity(2.0)
    right.set_velocity(2.0)
    rig.commit()
    assert rig.wheels == (0.0, 0.0)


def test_velocity_that_is_nan_stops_the_robot(rig: Rig) -> None:
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    with pytest.raises(InvalidCommandError):
        rig.robot.motors["left_motor"].set_velocity(math.nan)
    assert rig.wheels == (0.0, 0.0)


def test_closed_motor_refuses_commands_and_accepts_stops(rig: Rig) -> None:
    motor = rig.robot.motors["left_motor"]
    motor.close()
    motor.stop()
    with pytest.raises(DeviceClosedError):
        motor.set_velocity(1.0)
