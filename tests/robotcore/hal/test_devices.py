from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.errors import BackendError, DeviceClosedError, DeviceError, InvalidCommandError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Frame, MemoryDisplay
from robotcore.optics import Intrinsics
from tests.robotcore.fakes import NullMotor, NullRange, picture
from tests.texts import Raises


@pytest.fixture
def motor() -> NullMotor:
    return NullMotor("left", max_velocity=10.0)


@pytest.fixture
def sensor() -> NullRange:
    return NullRange(SteppedClock(20, lambda _: None), distance=0.5)


@pytest.mark.parametrize("fault", [OSError("no bus"), KeyError()], ids=["text", "no text"])
def test_what_a_driver_has_not_translated_is_reported_by_the_devices_name(
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


def test_what_a_driver_has_translated_is_raised_as_it_is(
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


def test_what_closing_raises_is_reported_by_the_device_s_name(
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
    def test_sends_what_is_asked_within_its_limit_and_says_so(
        self, motor: NullMotor, asked: float, sent: float
    ) -> None:
        assert motor.set_velocity(asked) == sent
        assert motor.sent == [sent]

    @pytest.mark.parametrize("velocity", [math.nan, math.inf, -math.inf])
    def test_stops_where_a_velocity_is_no_number(self, motor: NullMotor, velocity: float) -> None:
        motor.set_velocity(3.0)
        with pytest.raises(InvalidCommandError):
            motor.set_velocity(velocity)
        assert motor.sent == [3.0, 0.0]

    def test_a_motor_without_a_limit_refuses_infinity_too(self) -> None:
        motor = NullMotor("left", math.inf)
        with pytest.raises(InvalidCommandError):
            motor.set_velocity(math.inf)
        assert motor.sent == [0.0]

    def test_stops_when_it_is_closed_and_lets_the_hardware_go_once(self, motor: NullMotor) -> None:
        motor.set_velocity(3.0)
        motor.close()
        motor.close()
        assert motor.sent == [3.0, 0.0]
        assert motor.releases == 1

    def test_is_let_go_even_where_stopping_fails(self, motor: NullMotor) -> None:
        motor.is_broken = True
        with pytest.raises(DeviceError):
            motor.close()
        assert motor.releases == 1

    def test_refuses_a_command_but_no_stop_once_it_is_closed(self, motor: NullMotor) -> None:
        motor.close()
        motor.stop()
        with pytest.raises(DeviceClosedError):
            motor.set_velocity(1.0)
        assert motor.sent == [0.0]


class TestSensor:
    def test_gives_its_newest_sample(self, sensor: NullRange) -> None:
        sensor.distance = 0.7
        assert sensor.read().distance == 0.7

    def test_reads_nothing_once_it_is_closed(self, sensor: NullRange) -> None:
        sensor.close()
        with pytest.raises(DeviceClosedError):
            sensor.read()


class TestDisplay:
    def test_keeps_a_copy_of_the_newest_picture(self) -> None:
        display = MemoryDisplay("screen")
        image = np.zeros((2, 2, 3), np.uint8)
        display.show(image)
        image[:] = 9
        assert display.picture is not None
        assert not display.picture.any()

    def test_shows_nothing_once_it_is_closed(self) -> None:
        display = MemoryDisplay("screen")
        display.close()
        with pytest.raises(DeviceClosedError):
            display.show(picture())
        assert display.picture is None


class TestFrame:
    def test_is_grey_on_request_as_the_eye_weighs_colours(self) -> None:
        image = np.array([[(255, 0, 0), (0, 255, 0), (0, 0, 255)]], np.uint8)
        assert Frame(image, 0.0, 0).grey.tolist() == [[29, 150, 76]]

    def test_grey_is_made_once_and_read_only(self) -> None:
        frame = Frame(picture((1, 2, 3)), 0.0, 0)
        assert frame.grey is frame.grey
        with pytest.raises(ValueError, match="read-only"):
            frame.grey[0, 0] = 1


class TestIntrinsics:
    intrinsics = Intrinsics(320, 240, math.radians(90))

    def test_focal_length_is_half_the_width_where_the_field_of_view_is_a_right_angle(self) -> None:
        assert self.intrinsics.focal_length == pytest.approx(160.0)

    def test_axis_meets_the_picture_between_the_two_middle_pixels(self) -> None:
        assert (self.intrinsics.cx, self.intrinsics.cy) == (159.5, 119.5)

    @pytest.mark.parametrize("u, degrees", [(159.5, 0.0), (-0.5, 45.0), (319.5, -45.0)])
    def test_columns_on_the_left_have_positive_bearings(self, u: float, degrees: float) -> None:
        assert math.degrees(self.intrinsics.bearing(u)) == pytest.approx(degrees)
