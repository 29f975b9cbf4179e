"""What whoever connects a device is told, by its driver."""

from __future__ import annotations

from typing import Any

import pytest

from drivers.raspberrypi.encoders.pulses import Pulses
from drivers.raspberrypi.encoders.quadrature import Quadrature
from drivers.raspberrypi.header import pads_of
from drivers.raspberrypi.motors.hbridge import HBridge
from drivers.raspberrypi.motors.phase import PhaseEnable
from drivers.raspberrypi.ranging.ultrasonic import Ultrasonic
from robotcore.hardware import DeviceDriver

MODEL = {"dead_band": 0.1, "forward_rad_s": 14.0, "backward_rad_s": 14.0}


def notes(driver: DeviceDriver[Any, Any], **settings: object) -> str:
    return " ".join(driver.notes(None, driver.settings.model_validate(settings)))


def test_the_echo_of_an_ultrasonic_module_is_too_high_for_its_own_gpio() -> None:
    told = notes(Ultrasonic(), trigger=16, echo=26)
    assert "5 V" in told
    assert "1 kΩ from the echo to GPIO 26, and 2 kΩ from there to ground" in told


@pytest.mark.parametrize(
    "driver, lines",
    [(HBridge(), {"forward": 17, "backward": 27}), (PhaseEnable(), {"phase": 17, "enable": 27})],
)
def test_motors_are_never_fed_from_the_header(driver: DeviceDriver[Any, Any], lines: dict[str, int]) -> None:
    assert driver.supply == ("ground",)
    assert "a battery of their own" in notes(driver, model=MODEL, **lines)


def test_a_standby_line_is_pulled_down_and_one_that_is_missing_is_recommended() -> None:
    settings = {"forward": 17, "backward": 27, "model": MODEL}
    assert "10 kΩ from GPIO 22 (standby) to ground" in notes(HBridge(), **settings, standby=22)
    without = notes(HBridge(), **settings)
    assert "10 kΩ" not in without
    assert "There is no standby line" in without
    assert "an L298N's ENA and ENB joined" in without


def test_the_inputs_of_the_usual_boards_are_told_by_their_names() -> None:
    told = notes(HBridge(), forward=17, backward=27, model=MODEL)
    for inputs in ("TB6612: forward AIN1", "PWMB to 3.3 V", "standby nSLEEP", "L298N: forward IN1 and IN3"):
        assert inputs in told
    assert "AIN1" not in notes(PhaseEnable(), phase=17, enable=27, model=MODEL)


@pytest.mark.parametrize("driver, lines", [(Quadrature(), {"a": 5, "b": 6}), (Pulses(), {"gpio": 5})])
def test_encoders_are_fed_with_the_voltage_of_the_pins(driver: DeviceDriver[Any, Any], lines: dict[str, int]) -> None:
    assert driver.supply == ("3.3 V", "ground")
    assert "divider" in notes(driver, **lines)


@pytest.mark.parametrize("driver", [HBridge(), PhaseEnable(), Ultrasonic(), Quadrature(), Pulses()])
def test_what_feeds_a_device_is_on_the_header(driver: DeviceDriver[Any, Any]) -> None:
    assert all(pads_of(name) for name in driver.supply)
