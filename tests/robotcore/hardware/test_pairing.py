"""A wheel's motor and its encoder, by the drive."""

from __future__ import annotations

from robotcore.description import load_robot
from robotcore.hardware import encoder_of, motor_of

ROVER = load_robot("rover")


def test_the_two_on_a_wheel_find_each_other() -> None:
    assert encoder_of("left_motor", ROVER) == "left_encoder"
    assert motor_of("right_encoder", ROVER) == "right_motor"


def test_what_is_on_no_wheel_of_the_drive_has_no_other() -> None:
    bare = ROVER.model_copy(update={"drive": None})
    assert encoder_of("arm", ROVER) is motor_of("knob", ROVER) is None
    assert encoder_of("left_motor", bare) is motor_of("left_encoder", bare) is None


def test_a_wheel_may_have_no_encoder() -> None:
    assert ROVER.drive is not None
    drive = ROVER.drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    assert encoder_of("left_motor", ROVER.model_copy(update={"drive": drive})) is None
