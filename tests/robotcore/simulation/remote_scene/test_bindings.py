from __future__ import annotations

from typing import Any

import pytest

from robotcore.description import BatteryDescription, load_robot
from robotcore.errors import DescriptionError
from robotcore.simulation.remote_scene import ObjectKind, read_bindings
from robotcore.simulation.remote_scene.bindings import JointBinding
from tests.robotcore.simulation.remote_scene.memory import SECTION, rover


def refusal(**changes: Any) -> str:
    with pytest.raises(DescriptionError) as refused:
        read_bindings(rover(**changes), "memory")
    return str(refused.value)


def test_each_device_has_its_paths_and_the_kind_of_object_that_it_has_to_be() -> None:
    bound = {each.description.name: each for each in read_bindings(rover(), "memory")}
    assert bound["left_motor"].place.path == ("/rover/leftMotor",)
    assert bound["right_motor"].place.path == ("/gone", "/rover/rightMotor")
    kinds = {name: each.kind for name, each in bound.items()}
    assert kinds["left_encoder"] is ObjectKind.JOINT
    assert kinds["nose"] is ObjectKind.PROXIMITY_SENSOR
    assert kinds["eye"] is kinds["screen"] is ObjectKind.VISION_SENSOR


def test_only_the_devices_asked_for_are_placed() -> None:
    assert [each.description.name for each in read_bindings(rover(), "memory", {"eye"})] == ["eye"]


def test_wheel_may_be_reversed() -> None:
    bound, *_ = read_bindings(rover(left_motor={"path": "/left", "reversed": True}), "memory")
    assert bound.place == JointBinding(path=("/left",), reversed=True)


def test_a_scene_has_no_battery_and_needs_to_tell_of_none() -> None:
    powered = rover()
    cells = BatteryDescription(kind="battery", name="cells")
    powered = powered.model_copy(update={"devices": (*powered.devices, cells)})
    assert "cells" not in {each.description.name for each in read_bindings(powered, "memory")}
    description = {"memory": {**powered.backends["memory"], "cells": {"path": "/cells"}}}
    with pytest.raises(DescriptionError, match=r"memory\.cells: should not be there: a scene has no battery"):
        read_bindings(powered.model_copy(update={"backends": description}), "memory")


def test_display_without_an_object_is_left_out() -> None:
    section = {name: table for name, table in SECTION.items() if name != "screen"}
    robot = rover().model_copy(update={"backends": {"memory": section}})
    assert "screen" not in [each.description.name for each in read_bindings(robot, "memory")]


def test_robot_without_a_section_is_reported_what_to_write() -> None:
    with pytest.raises(DescriptionError, match=r'\[nowhere.left_motor\] with path = "/rover/left_motor"'):
        read_bindings(load_robot("rover"), "nowhere")


@pytest.mark.parametrize(
    "table, words",
    [
        ({}, "memory.nose.path: is missing. Add it: a path in quotes"),
        ({"path": 7}, "memory.nose.path: should be a path in quotes, or a list of them"),
        ({"path": ()}, "memory.nose.path: should be a path in quotes, or a list of them"),
        ({"path": "/nose", "reversed": True}, "memory.nose.reversed: is unknown"),
        ("/nose", "memory.nose: should be a table, got '/nose'"),
    ],
)
def test_fault_names_the_key_and_what_would_be_right(table: Any, words: str) -> None:
    assert words in refusal(nose=table)


def test_all_that_is_wrong_is_reported_at_once() -> None:
    lines = refusal(nose={}, left_motr={"path": "/left"}, eye={"path": "/eye", "as_fond": True}).splitlines()
    assert [line.removeprefix("robot rover: ").partition(":")[0] for line in lines] == [
        "memory.left_motr",
        "memory.nose.path",
        "memory.eye.as_fond",
    ]
