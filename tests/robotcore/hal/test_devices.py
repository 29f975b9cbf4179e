from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.errors import BackendError, DeviceClosedError, DeviceError, InvalidCommandError
from robotcore.hal.clock import SteppedClock
from robotcore.kinds.camera import Frame
from robotcore.kinds.display import MemoryDisplay
from tests.robotcore.fakes import NullMotor, NullRange, picture
from tests.texts import Raises


@pytest.fixture
def motor() -> NullMotor:
    return NullMotor("left", max_velocity=10.0)


@pytest.fixture
def sensor() -> NullRange:
    return NullRange(SteppedClock(20, lambda _: None), distance=0.5)


@pytest.mark.parametrize("fault", [OSError("no bus"), KeyError()], ids=["text", "no text"])
def test_other_exception_of_a_driver_becomes_a_device_error(
    motor: NullMotor, sensor: NullRange, monkeypatch: pytest.MonkeyPatch, fault: Exception, raises: Raises
) -> None:
    def fail(*_: object) -> None:
        raise fault

    monkeypatch.setattr(motor, "_apply", fail)
    monkeypatch.setattr(sensor, "_newest", fail)
    for name, use in (("left", lambda: motor.set_velocity(1.0)), ("left", motor.stop), ("nose", sensor.read)):
        with raises(DeviceError, "driver-error", device=name) as raised:
            use()
        assert raised.value.__cause__ is fault


def test_exception_of_a_kind_that_limits_a_command_becomes_a_device_error(
    motor: NullMotor, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(motor, "_limit", lambda command: 1.0 / command)
    with raises(DeviceError, "driver-error", device="left"):
        motor.set_velocity(0.0)


def test_error_of_the_framework_in_a_driver_is_raised_unchanged(
    motor: NullMotor, sensor: NullRange, monkeypatch: pytest.MonkeyPatch
) -> None:
    fault = BackendError("the simulator is gone")

    def fail(*_: object) -> None:
        raise fault

    monkeypatch.setattr(motor, "_apply", fail)
    monkeypatch.setattr(sensor, "_newest", fail)
    for use in (lambda: motor.set_velocity(1.0), motor.stop, sensor.read):
        with pytest.raises(BackendError) as raised:
            use()
        assert raised.value is fault


def test_exception_of_closing_becomes_a_device_error(
    motor: NullMotor, sensor: NullRange, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def fail() -> None:
        raise ValueError("bad handle")

    for device in (motor, sensor):
        monkeypatch.setattr(device, "_release", fail)
        with raises(DeviceError, "driver-error", device=device.name):
            device.close()
        device.close()


class TestMotor:
    @pytest.mark.parametrize("asked, sent", [(3.0, 3.0), (-3.0, -3.0), (10.0, 10.0), (11.0, 10.0), (-1e9, -10.0)])
    def test_command_is_limited_and_returned(self, motor: NullMotor, asked: float, sent: float) -> None:
        assert motor.set_velocity(asked) == sent
        assert motor.sent == [sent]

    @pytest.mark.parametrize("velocity", [math.nan, math.inf, -math.inf])
    def test_motor_stops_at_a_velocity_that_is_not_finite(self, motor: NullMotor, velocity: float) -> None:
        motor.set_velocity(3.0)
        with pytest.raises(InvalidCommandError):
            motor.set_velocity(velocity)
        assert motor.sent == [3.0, 0.0]

    def test_closing_stops_the_motor_and_releases_it_once(self, motor: NullMotor) -> None:
        motor.set_velocity(3.0)
        motor.close()
        motor.close()
        assert motor.sent == [3.0, 0.0]
        assert motor.releases == 1

    def test_motor_is_released_even_if_the_stop_fails(self, motor: NullMotor) -> None:
        motor.is_broken = True
        with pytest.raises(DeviceError):
            motor.close()
        assert motor.releases == 1

    def test_closed_motor_refuses_commands_but_not_a_stop(self, motor: NullMotor) -> None:
        motor.close()
        motor.stop()
        with pytest.raises(DeviceClosedError):
            motor.set_velocity(1.0)
        assert motor.sent == [0.0]


class TestSensor:
    def test_closed_sensor_refuses_to_read(self, sensor: NullRange) -> None:
        sensor.close()
        with pytest.raises(DeviceClosedError):
            sensor.read()


class TestDisplay:
    def test_memory_display_copies_the_newest_picture(self) -> None:
        display = MemoryDisplay("screen")
        image = np.zeros((2, 2, 3), np.uint8)
        display.show(image)
        image[:] = 9
        assert display.picture is not None
        assert not display.picture.any()

    def test_closed_display_refuses_pictures(self) -> None:
        display = MemoryDisplay("screen")
        display.close()
        with pytest.raises(DeviceClosedError):
            display.show(picture())
        assert display.picture is None


class TestFrame:
    def test_grey_picture_has_the_weights_of_luma(self) -> None:
        image = np.array([[(255, 0, 0), (0, 255, 0), (0, 0, 255)]], np.uint8)
        assert Frame(image, 0.0, 0).grey.tolist() == [[29, 150, 76]]

    def test_grey_picture_is_computed_once_and_read_only(self) -> None:
        frame = Frame(picture((1, 2, 3)), 0.0, 0)
        assert frame.grey is frame.grey
        with pytest.raises(ValueError, match="read-only"):
            frame.grey[0, 0] = 1
