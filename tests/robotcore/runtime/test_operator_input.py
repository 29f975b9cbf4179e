"""The input of the person who drives: velocities expire, and wrong commands are refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

from robotcore.description import load_robot
from robotcore.errors import InvalidCommandError, UnknownNameError, UsageError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Actuator
from robotcore.hal.kind import build_actuator
from robotcore.kinds.buzzer import BuzzerDescription
from robotcore.kinds.led import LedDescription
from robotcore.kinds.operator import OperatorSample
from robotcore.kinds.servo import ServoDescription
from robotcore.runtime.operator_input import LEASE_S, MAX_VELOCITY, OperatorInput, add_operator
from tests.texts import Raises

SENT: list[object] = []
DEVICES = (
    ServoDescription(kind="servo", name="pan", min_angle_rad=-1.0, max_angle_rad=1.0, max_velocity_rad_s=5.0),
    LedDescription(kind="led", name="lamp", is_rgb=True),
    BuzzerDescription(kind="buzzer", name="horn"),
)


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock(20, lambda steps: None)


@pytest.fixture
def operator(clock: SteppedClock) -> OperatorInput:
    SENT.clear()
    actuators: dict[str, Actuator[object]] = {each.name: build_actuator(each, SENT.append) for each in DEVICES}
    return OperatorInput(actuators, clock)


def read(operator: OperatorInput) -> OperatorSample:
    return operator.read(0.0, 0)


def test_a_velocity_expires_after_the_lease_and_the_person_still_holds_the_robot(
    operator: OperatorInput, clock: SteppedClock
) -> None:
    operator.drive(0.3, -1.0)
    clock.sleep_until(LEASE_S)
    sample = read(operator)
    assert (sample.is_driving, sample.is_silent, sample.linear, sample.angular) == (True, False, 0.3, -1.0)
    clock.sleep_until(LEASE_S + 0.01)
    sample = read(operator)
    assert (sample.is_driving, sample.is_silent, sample.linear, sample.angular) == (True, True, 0.0, 0.0)


def test_release_returns_the_robot_with_no_command_left(operator: OperatorInput) -> None:
    operator.drive(0.3, 0.0)
    operator.command("pan", 0.5)
    operator.release()
    sample = read(operator)
    assert (sample.is_driving, sample.linear, sample.commands) == (False, 0.0, ())


@pytest.mark.parametrize(
    "twist",
    [(math.nan, 0.0), (0.0, math.inf), (2 * MAX_VELOCITY, 0.0), (10**400, 0.0), (None, 0.0)],
    ids=range(5),
)
def test_an_invalid_velocity_is_refused_and_the_robot_stands(
    operator: OperatorInput, twist: tuple[Any, Any], raises: Raises
) -> None:
    operator.drive(0.3, 0.0)
    with raises(InvalidCommandError, "invalid-command"):
        operator.drive(*twist)
    sample = read(operator)
    assert (sample.is_driving, sample.linear, sample.angular) == (True, 0.0, 0.0)


def test_only_the_newest_command_to_each_actuator_remains(operator: OperatorInput) -> None:
    operator.command("pan", 0.5)
    operator.command("lamp", [1.0, 0.5, 0.0])
    operator.command("pan", 0.6)
    found = [(each.device, each.value, each.number) for each in read(operator).commands]
    assert found == [("lamp", (1.0, 0.5, 0.0), 2), ("pan", (0.6,), 3)]
    assert read(operator).is_driving
    assert not SENT  # only the loop sends


@pytest.mark.parametrize(
    "device, value",
    [
        ("pan", math.nan),
        ("pan", [0.1, 0.2]),
        ("pan", 10**400),
        ("pan", None),
        ("pan", "0.5"),
        ("lamp", 0.5),
        ("lamp", [0.0, math.inf, 0.0]),
        ("lamp", ["red", 0.0, 0.0]),
        ("horn", -1.0),
    ],
    ids=range(9),
)
def test_a_value_that_the_actuator_cannot_take_is_refused(
    operator: OperatorInput, device: str, value: Any, raises: Raises
) -> None:
    with raises(InvalidCommandError, "invalid-command"):
        operator.command(device, value)
    assert not read(operator).is_driving


def test_an_unknown_actuator_is_refused(operator: OperatorInput, raises: Raises) -> None:
    with raises(UnknownNameError, "unknown-actuator"):
        operator.command("pann", 0.5)


@pytest.mark.parametrize(
    "driving, text",
    [
        (lambda operator: None, "not driving"),
        (lambda operator: operator.drive(0.25, -1.0), "0.25 m/s, -1.00 rad/s"),
        (lambda operator: operator.command("pan", 0.5), "silent"),
    ],
)
def test_a_sample_as_text(operator: OperatorInput, clock: SteppedClock, driving: object, text: str) -> None:
    clock.sleep_until(1.0)
    assert callable(driving)
    driving(operator)
    assert read(operator).format_values() == text


def test_a_device_with_the_operators_name_is_refused(raises: Raises) -> None:
    rover = load_robot("rover")
    taken = rover.model_copy(update={"devices": (*rover.devices, LedDescription(kind="led", name="operator"))})
    with raises(UsageError, "operator-name-taken"):
        add_operator(taken)
