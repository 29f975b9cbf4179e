"""Mistakes in a motor's table of a robot's file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.hardware import bind_devices
from tests.drivers.raspberrypi.motors.rig import H_BRIDGE, MODEL
from tests.texts import CheckText, Raises


def bind_motor(**motor: Any) -> None:
    """Bind the rover with these keys in the left motor's table. The value None removes a key."""
    section = {key: value for key, value in {**H_BRIDGE, **motor}.items() if value is not None}
    bind({"left_motor": section})


def bind(sections: Mapping[str, Any]) -> None:
    rover = load_robot("rover")
    robot = rover.model_copy(update={"backends": {"raspberrypi": {**rover.backends["raspberrypi"], **sections}}})
    bind_devices(robot, "raspberrypi")


@pytest.mark.parametrize(
    "motor, key, kind",
    [
        ({"model": None}, "model", "missing-key"),
        ({"model": {"forward_rad_s": 14.0}}, "model.backward_rad_s", "missing-key"),
        ({"model": {**MODEL, "dead_bnd": 0.1}}, "model.dead_bnd", "unknown-key"),
        ({"forward": None}, "forward", "missing-key"),
    ],
    ids=["no model", "no velocity", "misspelt key", "no pin"],
)
def test_a_mistake_is_reported_with_its_key(motor: dict[str, Any], key: str, kind: str, raises: Raises) -> None:
    with raises(DescriptionError, kind, key=f"raspberrypi.left_motor.{key}"):
        bind_motor(**motor)


def test_an_enable_line_of_two_motors_may_be_their_standby(raises: Raises) -> None:
    left = {**H_BRIDGE, "enable": 22}
    right = {**left, "forward": 23, "backward": 24}
    with raises(DescriptionError, key="raspberrypi.right_motor.enable"):
        bind({"left_motor": left, "right_motor": right})
    with raises(DescriptionError, key="raspberrypi.right_motor.enable"):
        bind({"left_motor": left, "right_motor": {**right, "enable": 17}})


def test_a_check_warns_of_a_line_that_is_pulled_up_while_the_pi_starts(check_text: CheckText) -> None:
    rover = load_robot("rover")
    left = {**H_BRIDGE, "forward": 8}
    wired = rover.model_copy(
        update={"backends": {"raspberrypi": {**rover.backends["raspberrypi"], "left_motor": left}}}
    )
    backend = RaspberryPiBackend()
    (warning,) = backend.warnings(wired)
    check_text(warning)
    assert backend.warnings(rover) == []
    assert warning.removeprefix("left_motor: ") in [note for _, note in backend.wiring(wired).notes]
