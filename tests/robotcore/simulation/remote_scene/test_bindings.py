from __future__ import annotations

from typing import Any

import pytest

from robotcore.description import DeviceDescription, RobotDescription, load_robot
from robotcore.errors import DescriptionError
from robotcore.kinds.battery import BatteryDescription
from robotcore.kinds.bumper import BumperDescription
from robotcore.simulation.remote_scene import ObjectKind, list_scene_devices, read_bindings, warn_of_missing_kinds
from robotcore.simulation.remote_scene.scene_kinds import JointBinding
from tests.robotcore.simulation.remote_scene.memory import SECTION, rover
from tests.texts import CheckText, Raises


def test_each_binding_has_paths_and_a_required_kind_of_object() -> None:
    bound = {each.description.name: each for each in read_bindings(rover(), "memory")}
    assert bound["left_motor"].settings.path == ("/rover/leftMotor",)
    assert bound["right_motor"].settings.path == ("/gone", "/rover/rightMotor")
    kinds = {name: each.kind for name, each in bound.items()}
    assert kinds["left_encoder"] is ObjectKind.JOINT
    assert kinds["nose"] is ObjectKind.PROXIMITY_SENSOR
    assert kinds["eye"] is kinds["screen"] is ObjectKind.VISION_SENSOR


def test_only_the_requested_devices_are_bound() -> None:
    assert [each.description.name for each in read_bindings(rover(), "memory", {"eye"})] == ["eye"]


def test_joint_can_be_reversed() -> None:
    bound, *_ = read_bindings(rover(left_motor={"path": "/left", "reversed": True}), "memory")
    assert bound.settings == JointBinding(path=("/left",), reversed=True)


LACKING = pytest.mark.parametrize(
    "device",
    [BatteryDescription(kind="battery", name="cells"), BumperDescription(kind="bumper", name="front")],
    ids=lambda each: each.kind,
)


def add(device: DeviceDescription, **tables: Any) -> RobotDescription:
    robot = rover(**tables)
    return robot.model_copy(update={"devices": (*robot.devices, device)})


@LACKING
def test_device_of_a_kind_that_no_scene_has_is_not_bound(device: DeviceDescription) -> None:
    robot = add(device)
    assert device.name not in {each.description.name for each in read_bindings(robot, "memory")}
    assert list_scene_devices(robot) == {each.name for each in rover().devices}


@LACKING
def test_entry_of_a_device_that_no_scene_has_is_refused(device: DeviceDescription, raises: Raises) -> None:
    robot = add(device, **{device.name: {"path": "/rover/part"}})
    with raises(DescriptionError, key=f"memory.{device.name}"):
        read_bindings(robot, "memory")


def test_warning_is_only_for_kinds_that_other_simulators_have(check_text: CheckText) -> None:
    assert warn_of_missing_kinds(add(BatteryDescription(kind="battery", name="cells"))) == []
    (warning,) = warn_of_missing_kinds(add(BumperDescription(kind="bumper", name="front")))
    check_text(warning)


def test_display_without_an_entry_is_not_bound() -> None:
    section = {name: table for name, table in SECTION.items() if name != "screen"}
    robot = rover().model_copy(update={"backends": {"memory": section}})
    assert "screen" not in [each.description.name for each in read_bindings(robot, "memory")]


def test_missing_section_is_an_error_with_an_example(raises: Raises) -> None:
    with raises(DescriptionError, key="nowhere"):
        read_bindings(load_robot("rover"), "nowhere")


@pytest.mark.parametrize(
    "table, key, kind",
    [
        pytest.param({}, "memory.nose.path", "missing-key", id="empty"),
        pytest.param({"path": 7}, "memory.nose.path", "wrong-form", id="number"),
        pytest.param({"path": ()}, "memory.nose.path", "wrong-form", id="no-path"),
        pytest.param({"path": "/nose", "reversed": True}, "memory.nose.reversed", "unknown-key", id="unknown-key"),
        pytest.param("/nose", "memory.nose", "description", id="no-table"),
    ],
)
def test_mistake_names_its_key(table: Any, key: str, kind: str, raises: Raises) -> None:
    with raises(DescriptionError, kind, key=key):
        read_bindings(rover(nose=table), "memory")


def test_one_error_reports_all_mistakes(raises: Raises) -> None:
    changed = rover(nose={}, left_motr={"path": "/left"}, eye={"path": "/eye", "as_fond": True})
    with raises(DescriptionError, "unknown-device") as caught:
        read_bindings(changed, "memory")
    assert [caught.value.key, *(other.key for other in caught.value.others)] == [
        "memory.left_motr",
        "memory.nose.path",
        "memory.eye.as_fond",
    ]
