"""The velocity of a wheel by the true model of its motor, for a command that another model has converted to a duty."""

from __future__ import annotations

import json
from typing import Any

import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DescriptionError
from robotcore.fidelity.motor_conversion import DutyModels, MotorConversion, build_conversions
from robotcore.hardware.motor_model import MotorModel
from robotcore.kinds.motor import MotorDescription
from tests.texts import Raises

ROVER, FREENOVE = load_robot("rover"), load_robot("freenove-4wd")


def with_table(robot: RobotDescription, motor: str, **keys: Any) -> RobotDescription:
    """Return a robot with other keys in the table of a motor on a Raspberry Pi."""
    tables = robot.backends["raspberrypi"]
    changed = {**tables, motor: {**tables[motor], **keys}}
    return robot.model_copy(update={"backends": {**robot.backends, "raspberrypi": changed}})


TRUE_MODEL = {"dead_band": 0.2, "forward_rad_s": 16.0, "backward_rad_s": 15.0}
WEAK = with_table(ROVER, "left_motor", model=TRUE_MODEL)


def test_a_wheel_turns_as_fast_as_the_true_model_at_the_sent_duty() -> None:
    convert = build_conversions("raspberrypi", ROVER, WEAK)["left_motor"]
    duty = 0.1 + 0.9 * 7 / 14
    assert convert(7.0) == pytest.approx((duty - 0.2) / 0.8 * 16)
    assert convert(-7.0) == pytest.approx(-(duty - 0.2) / 0.8 * 15)
    assert (convert(0.0), convert(1.0)) == (0.0, 0.0)


def test_a_duty_has_the_resolution_of_the_driver() -> None:
    settings = {"driver": "sabertooth-motor", "port": "/dev/ttyUSB0", "model": {**TRUE_MODEL, "dead_band": 0.0}}
    tables = {f"{side}_motor": {**settings, "motor": number} for side, number in (("left", 1), ("right", 2))}
    robot = ROVER.model_copy(update={"backends": {"serial": tables}})
    found = build_conversions("serial", robot, robot)["left_motor"]
    assert found(8.0) == pytest.approx(16 * 64 / 127)
    exact = build_conversions("virtualpi", ROVER, ROVER)["right_motor"]
    assert exact(7.05) == pytest.approx(7.05)


def test_the_reach_is_that_of_the_true_model_at_full_duty() -> None:
    recorded = MotorModel(forward_rad_s=10.0, backward_rad_s=8.0)
    models = DutyModels(recorded, MotorModel(forward_rad_s=9.0, backward_rad_s=12.0))
    assert MotorConversion(make_motor(max_velocity_rad_s=20.0), models).reach == 12.0
    assert MotorConversion(make_motor(max_velocity_rad_s=5.0), models).reach == pytest.approx(7.5)
    assert MotorConversion(make_motor(max_velocity_rad_s=5.0)).reach == 5.0


def make_motor(**keys: Any) -> MotorDescription:
    return MotorDescription(kind="motor", name="left_motor", **keys)


def test_a_recorded_velocity_was_compensated_on_the_way_to_the_motor() -> None:
    motor = make_motor(max_velocity_rad_s=10.0, dead_band_rad_s=2.0, backward_gain=0.9)
    convert = MotorConversion(motor)
    assert [convert(each) for each in (5.0, -9.0, 0.0)] == pytest.approx([6.0, -10.0, 0.0])
    assert convert(100.0) == 10.0
    model = MotorModel(forward_rad_s=20.0, backward_rad_s=20.0)
    double = MotorModel(forward_rad_s=40.0, backward_rad_s=40.0)
    assert MotorConversion(motor, DutyModels(model, double))(5.0) == pytest.approx(12.0)


@pytest.mark.parametrize(
    "backend, recorded, robot",
    [
        ("kinematic", ROVER, WEAK),
        ("no-such-backend", ROVER, WEAK),
        ("raspberrypi", ROVER.model_copy(update={"backends": {}}), WEAK),
        ("raspberrypi", ROVER, ROVER.model_copy(update={"backends": {}})),
        ("raspberrypi", with_table(ROVER, "left_motor", driver="not-installed"), WEAK),
    ],
    ids=["simulator", "unknown", "recorded without section", "robot without section", "recorded driver is missing"],
)
def test_without_a_model_in_both_descriptions_a_wheel_turns_as_commanded(
    backend: str, recorded: RobotDescription, robot: RobotDescription
) -> None:
    found = build_conversions(backend, recorded, robot)
    assert [(name, each(5.0), each.models) for name, each in found.items()] == [
        ("left_motor", 5.0, None),
        ("right_motor", 5.0, None),
    ]


def test_a_wheel_that_an_encoder_corrects_turns_as_commanded() -> None:
    controlled = with_table(ROVER, "left_motor", control={})
    found = build_conversions("raspberrypi", controlled, WEAK)
    assert [name for name, each in found.items() if each.models] == ["right_motor"]


def test_a_mistake_in_the_robots_file_is_an_error(raises: Raises) -> None:
    with raises(DescriptionError, "missing-key"):
        build_conversions("raspberrypi", ROVER, with_table(ROVER, "left_motor", model={}))


def test_motors_are_paired_by_their_places_and_not_by_their_names() -> None:
    text = (
        json.dumps(ROVER.model_dump(mode="json"))
        .replace("left_motor", "port_motor")
        .replace("right_motor", "starboard")
    )
    other = RobotDescription.model_validate_json(text)
    assert other.drive
    found = build_conversions("raspberrypi", WEAK, other)
    bands = {name: each.models.recorded.dead_band for name, each in found.items() if each.models}
    assert bands == {"port_motor": 0.2, "starboard": 0.1}


def test_each_wheel_of_a_side_has_its_own_conversion() -> None:
    drive = FREENOVE.drive
    assert drive
    changed = with_table(FREENOVE, drive.left_motors[1], model=TRUE_MODEL)
    found = build_conversions("raspberrypi", FREENOVE, changed)
    assert sorted(found) == sorted(drive.motors)
    changed_motors = [name for name, each in found.items() if each.models and each.models.other.dead_band == 0.2]
    assert changed_motors == [drive.left_motors[1]]
