from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.errors import DeviceError, DeviceGroupError, UnknownNameError, UnmetNeedError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.robot import Robot, Role
from tests.robotcore.fakes import NullCamera, NullMotor, NullRange, Rig
from tests.texts import Raises


def make(*names: str, release: Callable[[], None] | None = None) -> tuple[Robot, list[NullMotor]]:
    motors = [NullMotor(name) for name in names]
    for motor in motors:
        motor.set_velocity(1.0)
    return Robot("rover", SteppedClock(20, lambda _: None), motors, release=release), motors


class TestClosing:
    def test_all_motors_stop_before_one_is_released(self) -> None:
        order: list[str] = []

        class Motor(NullMotor):
            def _apply(self, rad_s: float) -> None:
                order.append(f"stop {self.name}")

            def _release(self) -> None:
                order.append(f"release {self.name}")

        robot = Robot("rover", SteppedClock(20, lambda _: None), [Motor("left"), Motor("right")])
        robot.close()
        assert order[:2] == ["stop left", "stop right"]
        assert sorted(order[2:]) == sorted([*order[:2], "release left", "release right"])

    @pytest.mark.parametrize("broken", [0, 1, 2])
    def test_other_motors_stop_if_one_fails(self, broken: int) -> None:
        robot, motors = make("left", "right", "arm")
        motors[broken].is_broken = True
        with pytest.raises(DeviceGroupError):
            robot.close()
        assert all(motor.sent[-1] == 0.0 for motor in motors if not motor.is_broken)
        assert [motor.releases for motor in motors] == [1, 1, 1]

    def test_backend_is_released_last_even_if_a_device_fails(self) -> None:
        released_after: list[int] = []
        robot, motors = make("left", release=lambda: released_after.append(motors[0].releases))
        motors[0].is_broken = True
        with pytest.raises(DeviceGroupError):
            robot.close()
        assert released_after == [1]

    def test_equal_failures_are_reported_once(self) -> None:
        beneath, motors = make("left", "right")
        motors[0].is_broken = motors[1].is_broken = True
        robot = Robot("rover", SteppedClock(20, lambda _: None), [motors[0]], release=beneath.close)
        with pytest.raises(DeviceGroupError) as raised:
            robot.close()
        assert [each.device for each in raised.value.failures if isinstance(each, DeviceError)] == ["left", "right"]

    def test_second_close_does_nothing(self) -> None:
        releases: list[str] = []
        robot, motors = make("left", release=lambda: releases.append("once"))
        robot.close()
        robot.close()
        assert (releases, motors[0].releases) == (["once"], 1)

    def test_error_in_the_with_block_closes_the_robot_and_is_raised(self) -> None:
        robot, motors = make("left")
        with pytest.raises(KeyError), robot:
            raise KeyError
        assert motors[0].sent[:2] == [1.0, 0.0]


class TestRoles:
    def test_the_first_device_of_a_kind_fills_its_role(self) -> None:
        clock = SteppedClock(20, lambda _: None)
        noses, eye = [NullRange(clock, "front"), NullRange(clock, "back")], NullCamera(clock)
        robot = Robot("rover", clock, [*noses, eye])
        assert robot.range is noses[0]
        assert robot.camera is eye
        assert robot["back"] is noses[1]

    @pytest.mark.parametrize("role", Role)
    def test_missing_role_is_reported_by_its_name(self, role: Role, raises: Raises) -> None:
        robot = Robot("pole", SteppedClock(20, lambda _: None), [])
        assert not robot.has(role)
        with raises(UnmetNeedError):
            getattr(robot, role.value)

    @pytest.mark.parametrize("role", Role)
    def test_robot_has_a_role_with_an_open_device(self, role: Role) -> None:
        robot = Rig().robot
        assert robot.has(role)
        assert getattr(robot, role.value)

    def test_unknown_device_suggests_the_nearest_name(self, raises: Raises) -> None:
        robot, _ = make("left", "right")
        with raises(UnknownNameError, "unknown-device"):
            robot["lef"]

    def test_device_that_is_not_open_is_not_among_the_needs(self, raises: Raises) -> None:
        robot, _ = make("left", "right")
        with raises(UnknownNameError, "unknown-device"):
            robot["pan"]

    def test_motors_are_a_mapping_by_name(self) -> None:
        assert list(Rig().robot.motors) == ["left_motor", "right_motor"]
