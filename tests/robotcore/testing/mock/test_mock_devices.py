"""Mock devices of kinds that the mock does not name: a bumper, and the kinds of another package."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import pytest

from robotcore.errors import UsageError
from robotcore.hal.device import Unit
from robotcore.hal.robot import Robot, Role
from robotcore.kinds import Bumper
from robotcore.kinds.bumper import BumperDescription
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.testing import LOST, MockRobot
from tests.doubles import foreign_kinds
from tests.doubles.foreign_kinds import GripperDescription, Tilt, TiltDescription, rover_with
from tests.texts import Raises


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign_kinds.install(monkeypatch)


def read(robot: MockRobot, sensor: str) -> Any:
    device: Any = robot.layered[sensor]
    return device.read()


def bumpy(**options: Any) -> MockRobot:
    return MockRobot(rover_with(BumperDescription(kind="bumper", name="front")), **options)


class BackOff(Behaviour):
    """An app that drives backward while a bumper is pressed."""

    needs: ClassVar = {Role.DRIVE, Bumper}

    def step(self, robot: Robot) -> Status:
        is_pressed = any(bumper.read().is_pressed for bumper in robot.all(Bumper))
        robot.drive.set_velocity(-0.1 if is_pressed else 0.1, 0.0)
        return Status.RUNNING


def test_app_with_a_bumper_runs_on_a_script() -> None:
    robot = bumpy(range=2.0, readings={"front": [False, True, False]})
    robot.run(BackOff(), ticks=4)
    assert [wheels.left > 0 for wheels in robot.wheels] == [True, False, True, True]


def test_bumper_without_a_script_is_not_pressed() -> None:
    assert read(bumpy(), "front").is_pressed is False


def test_lost_samples_and_exceptions_are_for_all_kinds() -> None:
    robot = bumpy(readings={"front": [True, LOST]})
    robot.advance()
    sample = read(robot, "front")
    assert (sample.is_pressed, sample.sequence) == (True, 0)


def tilting(script: Any) -> MockRobot:
    return MockRobot(rover_with(TiltDescription(name="tilt")), readings={"tilt": script})


def test_reading_of_several_values_is_a_mapping_and_other_fields_are_0() -> None:
    robot = tilting([{"roll": 0.1, "pitch": -0.2, "steps": 3}, {"roll": 1}])
    assert read(robot, "tilt") == Tilt(0.1, -0.2, 3, 0.0, 0)
    robot.advance()
    assert read(robot, "tilt") == Tilt(1.0, 0.0, 0, 0.05, 1)


@pytest.mark.parametrize(
    "robot, reading",
    [
        pytest.param(bumpy, 1, id="number for a boolean"),
        pytest.param(tilting, 0.1, id="value without a field"),
        pytest.param(tilting, {"rol": 0.1}, id="unknown field"),
        pytest.param(tilting, {"roll": math.nan}, id="nan"),
        pytest.param(tilting, {"steps": 0.5}, id="part of a whole number"),
    ],
)
def test_wrong_reading_is_refused_at_once(robot: Any, reading: Any, raises: Raises) -> None:
    device = "front" if robot is bumpy else "tilt"
    with raises(UsageError, "script-reading", device=device):
        robot(readings={"front": reading}) if robot is bumpy else robot(reading)


def test_single_value_may_be_a_mapping_too() -> None:
    robot = MockRobot(range={"distance": 0.5, "point": (0.5, 0.0, 0.0)}).layered
    assert (robot.range.read().distance, robot.range.read().point) == (0.5, (0.5, 0.0, 0.0))


def test_actuator_of_any_kind_records_its_commands_within_its_limits() -> None:
    robot = MockRobot(rover_with(GripperDescription(name="gripper")))
    gripper: Any = robot.layered["gripper"]
    gripper.send(0.3)
    robot.advance()
    gripper.send(0.05)
    assert [tuple(command) for command in robot.commands["gripper"]] == [(0.0, 0.1), (0.05, 0.05)]


@dataclass(frozen=True)
class Colour:
    rgb: Annotated[tuple[float, ...], Unit("")]
    centre: Annotated[tuple[float, float], Unit("m")]
    clear: Annotated[float, Unit("")]
    time: float
    sequence: int


@pytest.mark.parametrize(
    "readings, kind",
    [({}, "script-incomplete"), ({"tilt": {"clear": 0.3}}, "script-incomplete"), ({"tilt": {"rgb": "red"}}, None)],
    ids=["no-script", "no-rgb", "text"],
)
def test_reading_of_a_tuple_names_the_field(
    readings: Any, kind: str | None, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setitem(foreign_kinds.KINDS, "tilt_sensor", replace(foreign_kinds.KINDS["tilt_sensor"], sample=Colour))
    with raises(UsageError, kind or "script-reading", device="tilt"):
        read(MockRobot(rover_with(TiltDescription(name="tilt")), readings=readings), "tilt")


def test_tuple_of_a_fixed_length_has_zeros_without_a_script(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(foreign_kinds.KINDS, "tilt_sensor", replace(foreign_kinds.KINDS["tilt_sensor"], sample=Colour))
    robot = MockRobot(rover_with(TiltDescription(name="tilt")), readings={"tilt": {"rgb": (0.5,)}})
    assert read(robot, "tilt") == Colour((0.5,), (0.0, 0.0), 0.0, 0.0, 0)
