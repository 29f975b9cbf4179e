"""The needs of an app: roles, names of devices, and classes of kinds."""

from __future__ import annotations

from typing import Any

import pytest

from robotcore.description import load_robot
from robotcore.errors import UnmetNeedError, UsageError
from robotcore.hal.device import Device, Sensor
from robotcore.hal.robot import Role
from robotcore.kinds import Imu, Motor
from robotcore.runtime.needs import Need, format_need, needed_devices
from tests.doubles import foreign_kinds
from tests.doubles.foreign_kinds import ToolMotorDescription, rover_with
from tests.robotcore.fakes import ROVER
from tests.texts import Raises


@pytest.mark.parametrize(
    "needs, wants",
    [(Role.RANGE, ()), ((), Role.RANGE), (None, ()), (3, ()), (len, ())],
    ids=["needs", "wants", "none", "number", "function"],
)
def test_needs_and_wants_without_a_set_are_refused(needs: Any, wants: Any, raises: Raises) -> None:
    with raises(UsageError, "needs-not-a-set"):
        needed_devices(ROVER, needs, wants)


@pytest.mark.parametrize("need", [Sensor, Device, int, 1, None, ["gripper"]])
def test_need_that_is_no_role_no_name_and_no_kind_is_refused(need: Any, raises: Raises) -> None:
    with raises(UsageError, "wrong-need"):
        needed_devices(ROVER, [need])


@pytest.mark.parametrize("need", ["gripper", "noze", "camera", "imu", "Imu", Imu, Role.DRIVE], ids=format_need)
def test_need_that_the_robot_lacks_is_reported_with_what_to_add(need: Need, raises: Raises) -> None:
    robot = load_robot("rover")
    devices = tuple(device for device in robot.devices if device.kind not in ("camera", "motor", "encoder"))
    with raises(UnmetNeedError, "unmet-need"):
        needed_devices(robot.model_copy(update={"devices": devices, "drive": None}), {need})


def test_need_of_a_kind_includes_kinds_that_inherit_it(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign_kinds.install(monkeypatch)
    robot = rover_with(ToolMotorDescription(name="mower"))
    assert needed_devices(robot, {Motor}) == {"left_motor", "right_motor", "mower"}


def test_a_role_is_not_a_set_of_letters() -> None:
    with pytest.raises(TypeError, match=r"Write \{Role.DRIVE\}"):
        frozenset(Role.DRIVE)
