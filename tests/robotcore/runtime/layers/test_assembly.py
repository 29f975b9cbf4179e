from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import pytest

from robotcore.description import Conditions, load_robot
from robotcore.errors import (
    DeviceError,
    UnmetNeedError,
)
from robotcore.geometry import Wheels
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.hal.drive import WheelPath
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.camera import CameraDescription
from robotcore.runtime.layers import assemble
from robotcore.runtime.layers.base import MotorOutput, Reader, Send, Tap
from robotcore.runtime.needs import needed_devices
from robotcore.safety.command_filter import CommandFilter
from tests.robotcore.fakes import ROVER, UNHURRIED, NullEncoder, Rig
from tests.robotcore.runtime.faults.rigs import layers
from tests.texts import Raises


class TestNeededDevices:
    @pytest.mark.parametrize(
        "robot, needs, wants, names",
        [
            ("rover", Role.DRIVE, set(), {"left_motor", "right_motor", "left_encoder", "right_encoder", "nose"}),
            ("rover", Role.CAMERA, {Role.DISPLAY}, {"eye", "screen"}),
            ("rover", Role.RANGE, set(), {"nose"}),
            ("lookout", Role.CAMERA, {Role.DRIVE}, {"eye"}),
        ],
    )
    def test_roles_need_their_devices_and_a_drive_its_range_sensor(
        self, robot: str, needs: Role, wants: set[Role], names: set[str]
    ) -> None:
        assert needed_devices(load_robot(robot), {needs}, wants) == names

    def test_unmet_need_is_refused(self) -> None:
        with pytest.raises(UnmetNeedError):
            needed_devices(load_robot("lookout"), {Role.CAMERA, Role.DRIVE})


class TestSensors:
    def test_device_returns_one_sample_in_a_tick(self) -> None:
        rig = Rig()
        first = rig.robot.range.read()
        assert rig.robot.range.read() is first
        assert rig.nose.reads == 1
        rig.sleep(0.05)
        assert rig.robot.range.read() is not first


class TestConditions:
    def test_wheel_gain_applies_between_the_command_filter_and_the_driver(self) -> None:
        rig = Rig(description=UNHURRIED)
        assembled = assemble(rig.raw, UNHURRIED, 20, conditions=Conditions(wheel_gain_left=0.5, wheel_gain_right=1.5))
        assert assembled.command_filter
        assert assembled.robot.drive.set_wheels(4.0, 4.0) == (4.0, 4.0)
        assembled.command_filter.commit()
        assert rig.wheels == (2.0, 6.0)
        assembled.clock.sleep_until(0.125)
        assert rig.wheels == (0.0, 0.0)
        assembled.robot.close()
        assert (rig.left.releases, rig.right.releases) == (1, 1)


class TestDrive:
    def test_robot_without_open_motors_has_no_drive(self) -> None:
        rig = Rig(names=("eye",))
        assert rig.assembled.command_filter is None
        assert not rig.robot.has(Role.DRIVE)

    def test_pose_without_encoders_follows_the_commands_until_the_deadman_stops(self) -> None:
        rig = Rig(description=UNHURRIED)
        rig.robot.drive.set_velocity(0.2, 0.0)
        rig.commit()
        assert rig.robot.drive.pose == pytest.approx((0.01, 0.0, 0.0))
        rig.sleep(1.0)
        assert rig.robot.drive.pose == pytest.approx((0.2 * 0.125, 0.0, 0.0))


class TestEncoders:
    def test_pose_of_a_late_encoder_is_corrected_by_the_commands(self) -> None:
        rig = Rig(description=UNHURRIED)
        encoders = NullEncoder(rig.clock, "left_encoder"), NullEncoder(rig.clock, "right_encoder")
        raw = Robot("rig", rig.clock, [rig.left, rig.right, *encoders])
        assembled = assemble(raw, UNHURRIED, 20, faults=layers("encoders delay=0.1", clock=rig.clock))
        drive, poses = assembled.robot.drive, []
        for _ in range(6):
            drive.set_velocity(0.2, 0.0)
            poses.append(drive.pose.x)
            assert assembled.command_filter
            assembled.command_filter.commit()
            assembled.clock.sleep_until(assembled.clock.now() + 0.05)
            for encoder in encoders:
                encoder.angle += 0.01 / 0.0325
        assert poses == pytest.approx([0.01 * tick for tick in range(6)])


class RecordingTap(Tap):
    """Records the calls that pass through it."""

    def __init__(self) -> None:
        self.calls: list[object] = []

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def record_read() -> SampleT:
            self.calls.append(sensor.name)
            return read()

        return record_read

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        self.calls.append(actuator.name)
        return send

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        ask = inner.ask
        inner.ask = lambda wheels: self.calls.append(wheels) or ask(wheels)  # type: ignore[method-assign,func-returns-value]
        return inner

    def wheel_path(self, read: Callable[[], WheelPath]) -> Callable[[], WheelPath]:
        return lambda: WheelPath(Wheels(2.0, 2.0))


def test_tap_gets_the_apps_command_before_any_rule_and_can_replace_the_path_of_the_wheels() -> None:
    rig, tap = Rig(), RecordingTap()
    robot = assemble(rig.raw, ROVER, 20, taps=[tap]).robot
    assert robot.drive.set_wheels(12.0, 6.0) == (3.0, 1.5)
    assert tap.calls == ["screen", (12.0, 6.0), "nose"]
    assert robot.drive.pose == pytest.approx((0.065, 0.0, 0.0))


class Broken(Tap):
    """A layer whose functions raise an exception."""

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def fail() -> SampleT:
            raise ZeroDivisionError

        return fail

    def motor(self, motor: MotorOutput) -> MotorOutput:
        def fail(rad_s: float) -> float:
            raise ZeroDivisionError

        return dataclasses.replace(motor, set_velocity=fail)


def test_exception_of_a_layer_is_a_device_error_and_stops_the_wheels(raises: Raises) -> None:
    rig = Rig(description=UNHURRIED)
    assembled = assemble(rig.raw, rig.description, 20, faults=[Broken()])
    with raises(DeviceError, "driver-error", device="eye"):
        assembled.robot.camera.read()
    assert assembled.command_filter
    assembled.command_filter.ask(Wheels(-1.0, -1.0))
    with raises(DeviceError, "driver-error", device="left_motor"):
        assembled.command_filter.commit()
    assert rig.wheels == (0.0, 0.0)


def test_exception_of_a_kind_that_configures_a_device_is_a_device_error(
    monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(CameraDescription, "configure", lambda *_: 1 / 0)
    with raises(DeviceError, "driver-error", device="eye"):
        assemble(Rig().raw, ROVER, 20)


def test_app_sensor_shows_the_attributes_of_its_kind() -> None:
    robot = Rig().robot
    sensor = robot.range
    assert sensor.mount == robot.camera.mount == (0.14, 0.0, 0.0)
    assert {"cone", "min_range", "max_range", "mount"} <= set(dir(sensor))
    assert type(sensor).__name__ == "RangeSensor"
    with pytest.raises(AttributeError):
        _ = sensor.value  # type: ignore[attr-defined]
