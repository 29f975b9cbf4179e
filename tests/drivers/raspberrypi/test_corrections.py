"""The settings by which the Pi's drivers correct wrong wires and mountings."""

from __future__ import annotations

from typing import Any

import pytest

from drivers.raspberrypi.cameras.v4l2 import UsbCamera
from drivers.raspberrypi.encoders import Pulses, Quadrature
from drivers.raspberrypi.lights import LedDriver, RgbLedDriver
from drivers.raspberrypi.line_sensors import PinLineSensorDriver
from drivers.raspberrypi.motors.boards import HBridge, PhaseEnable
from drivers.raspberrypi.mpu6050 import MPU6050
from drivers.raspberrypi.pwm.motors import HBridgeChannelDriver, PhaseChannelDriver
from drivers.raspberrypi.servos import PinServoDriver
from drivers.serial.boards.hoverboard.drivers import HoverboardEncoder
from robotcore.hal import device_test as mistakes
from robotcore.hardware import DeviceDriver
from robotcore.hardware.motor_model import MotorModel

MODEL = MotorModel(forward_rad_s=14.0, backward_rad_s=14.0)
H_BRIDGE = HBridge(forward=17, backward=27, model=MODEL)
BOARD = HBridgeChannelDriver.model_validate({"board": "adafruit-motor-hat", "motor": "M1", "model": MODEL})
PHASE = PhaseChannelDriver(pwm=4, phase=17, model=MODEL)
SERVO = PinServoDriver(gpio=18)
LAMP = RgbLedDriver(red=12, green=13, blue=19)
ROW = PinLineSensorDriver(gpios=(9, 10, 11))
CAMERA = UsbCamera(rotate_180=True)


@pytest.mark.parametrize(
    "driver,mistake,observed,settings",
    [
        (H_BRIDGE, mistakes.REVERSED, None, {"forward": 27, "backward": 17}),
        (BOARD, mistakes.REVERSED, None, {"forward": BOARD.backward, "backward": BOARD.forward}),
        (PHASE, mistakes.REVERSED, None, {"forward_is_high": True}),
        (PhaseEnable(phase=5, enable=6, model=MODEL), mistakes.REVERSED, None, None),
        (Quadrature(a=5, b=6), mistakes.REVERSED, None, {"a": 6, "b": 5}),
        (Pulses(gpio=5), mistakes.REVERSED, None, None),
        (HoverboardEncoder(side="left", port="/dev/ttyUSB0"), mistakes.REVERSED, None, {"inverted": True}),
        (MPU6050(), mistakes.REVERSED, None, {"is_upside_down": True}),
        (SERVO, mistakes.REVERSED, None, {"min_pulse_s": 0.002, "max_pulse_s": 0.001}),
        (SERVO, mistakes.AT_OTHER_ANGLES, [0.1, 1.5], {"min_pulse_s": 0.0011, "max_pulse_s": 0.0025}),
        (SERVO, mistakes.AT_OTHER_ANGLES, [-2.0, 1.0], None),
        (SERVO, mistakes.INVERTED, None, None),
        (LedDriver(gpio=4), mistakes.INVERTED, None, {"active_high": False}),
        (LAMP, mistakes.IN_OTHER_ORDER, [2, 0, 1], {"red": 19, "green": 12, "blue": 13}),
        (ROW, mistakes.IN_OTHER_ORDER, [2, 1, 0], {"gpios": [11, 10, 9]}),
        (ROW, mistakes.INVERTED, None, {"active_high": False}),
        (CAMERA, mistakes.ROTATED_180, None, {"rotate_180": False}),
        (CAMERA, mistakes.FLIPPED_HORIZONTALLY, None, {"flip_horizontal": True}),
        (CAMERA, mistakes.RED_AND_BLUE_SWAPPED, None, {"swap_red_blue": True}),
        (CAMERA, "unknown", None, None),
    ],
)
def test_a_driver_corrects_a_mistake(
    driver: DeviceDriver, mistake: str, observed: Any, settings: dict[str, Any] | None
) -> None:
    assert driver.correct(mistake, observed) == settings


def test_the_settings_of_a_camera_add_up() -> None:
    assert CAMERA.transformation == (True, True, False)
    assert UsbCamera(rotate_180=True, flip_vertical=True).transformation == (False, True, False)
