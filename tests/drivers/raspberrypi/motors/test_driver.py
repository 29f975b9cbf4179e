"""What is told of a motor's section that is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.hardware import bind_devices
from tests.drivers.raspberrypi.motors.rig import H_BRIDGE, MODEL


def find_faults_of_motor(**motor: Any) -> list[str]:
    """Return what is told of the left motor's section, with these keys in place of its own; None takes one out."""
    section = {key: value for key, value in {**H_BRIDGE, **motor}.items() if value is not None}
    return faults({"left_motor": section})


def faults(section: Mapping[str, Any]) -> list[str]:
    rover = load_robot("rover")
    robot = rover.model_copy(update={"backends": {"raspberrypi": {**rover.backends["raspberrypi"], **section}}})
    with pytest.raises(DescriptionError) as raised:
        bind_devices(robot, "raspberrypi")
    return [line.removeprefix("robot rover: raspberrypi.") for line in str(raised.value).splitlines()]


def test_a_model_that_is_missing_is_shown_with_where_to_read_on() -> None:
    (fault,) = find_faults_of_motor(model=None)
    shown = "{ dead_band = 0.1, forward_rad_s = 14.0, backward_rad_s = 14.0 }"
    assert fault.startswith(f"left_motor.model: is missing. Add it: a table such as {shown}; docs/raspberry-pi.md")


def test_a_velocity_of_a_model_that_is_missing_is_reported_with_what_it_is() -> None:
    (fault,) = find_faults_of_motor(model={"forward_rad_s": 14.0})
    assert fault == (
        "left_motor.model.backward_rad_s: is missing. Add it: the wheel's velocity at full duty in rad/s, such as 14.0"
    )


def test_a_key_of_a_model_that_is_misspelt_is_reported_with_the_nearest() -> None:
    (fault,) = find_faults_of_motor(model={**MODEL, "dead_bnd": 0.1})
    assert fault.endswith("Did you mean 'dead_band'?")


def test_a_pin_that_is_missing_is_reported_with_what_it_is() -> None:
    assert find_faults_of_motor(forward=None) == [
        "left_motor.forward: is missing. Add it: the number of a GPIO on the header (BCM), 0 to 27"
    ]


def test_an_enable_line_that_two_motors_want_may_be_their_standby() -> None:
    left = {**H_BRIDGE, "enable": 22}
    right = {**left, "forward": 23, "backward": 24}
    (clash,) = faults({"left_motor": left, "right_motor": right})
    assert clash.startswith("right_motor.enable: GPIO 22 is already raspberrypi.left_motor.enable. ")
    assert clash.endswith("Connect one of them elsewhere, or make it standby, which motors may share")
    (clash,) = faults({"left_motor": left, "right_motor": {**right, "enable": 17}})
    assert clash.endswith("Connect one of them elsewhere")


def test_a_check_warns_of_a_line_that_is_pulled_up_while_the_pi_starts() -> None:
    rover = load_robot("rover")
    left = {**H_BRIDGE, "forward": 8}
    wired = rover.model_copy(
        update={"backends": {"raspberrypi": {**rover.backends["raspberrypi"], "left_motor": left}}}
    )
    backend = RaspberryPiBackend()
    (warning,) = backend.warnings(wired)
    assert warning.startswith("left_motor: GPIO 0 to 8 are pulled up")
    assert "GPIO 8 may turn this motor then. Take GPIO 9 to 27" in warning
    assert backend.warnings(rover) == []
    assert warning.removeprefix("left_motor: ") in [note for _, note in backend.wiring(wired).notes]
