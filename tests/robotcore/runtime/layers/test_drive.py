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


def test_motors_that_are_reported_one_by_one_are_sent_together(rig: Rig) -> None:
    left, right = rig.robot.motors.values()
    assert left.set_velocity(1.0) == 1.0
    assert right.set_velocity(2.0) == 2.0
    assert rig.left.sent == []
    rig.commit()
    assert rig.wheels == (1.0, 2.0)


def test_a_number_of_an_array_that_changes_later_is_sent_as_it_was(rig: Rig) -> None:
    speeds: Any = np.array([1.0, 2.0])
    left, right = rig.robot.motors.values()
    left.set_velocity(speeds[0, ...])
    right.set_velocity(speeds[1, ...])
    speeds *= 500
    rig.commit()
    assert rig.wheels == (1.0, 2.0)


def test_a_wheel_that_is_not_reported_keeps_its_velocity(rig: Rig) -> None:
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    rig.robot.motors["left_motor"].set_velocity(3.0)
    rig.commit()
    assert rig.wheels == (3.0, 2.0)


def test_one_wheel_too_fast_slows_the_other_in_proportion(rig: Rig) -> None:
    left, right = rig.robot.motors.values()
    left.set_velocity(6.0)
    assert right.set_velocity(24.0) == 12.0
    rig.commit()
    assert rig.wheels == (3.0, 12.0)


def test_stopping_one_wheel_stops_the_robot_at_once(rig: Rig) -> None:
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    rig.robot.motors["left_motor"].stop()
    assert rig.wheels == (0.0, 0.0)


def test_the_guard_holds_for_single_motors_too(rig: Rig) -> None:
    rig.nose.distance = 0.05
    left, right = rig.robot.motors.values()
    left.set_velocity(2.0)
    right.set_velocity(2.0)
    rig.commit()
    assert rig.wheels == (0.0, 0.0)


def test_a_velocity_that_is_no_number_stops_the_robot(rig: Rig) -> None:
    rig.robot.drive.set_wheels(1.0, 2.0)
    rig.commit()
    with pytest.raises(InvalidCommandError):
        rig.robot.motors["left_motor"].set_velocity(math.nan)
    assert rig.wheels == (0.0, 0.0)


def test_once_it_is_closed_a_motor_refuses_commands_and_lets_stops_pass(rig: Rig) -> None:
    motor = rig.robot.motors["left_motor"]
    motor.close()
    motor.stop()
    with pytest.raises(DeviceClosedError):
        motor.set_velocity(1.0)
