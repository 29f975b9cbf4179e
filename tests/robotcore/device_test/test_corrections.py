"""Corrections of the tables in a robot's file."""

from __future__ import annotations

import pytest

from robotcore.description import load_robot
from robotcore.device_test.corrections import Corrections
from robotcore.hal.backend import load_backend


@pytest.fixture
def corrections() -> Corrections:
    return Corrections(load_robot("rover"), load_backend("virtualpi"))


def test_without_a_mistake_no_table_changes(corrections: Corrections) -> None:
    assert corrections.section == "raspberrypi"
    assert corrections.tables == {}


def test_a_swap_and_a_reversal_add_up(corrections: Corrections) -> None:
    assert corrections.swap({"left_motor": "right_motor", "right_motor": "left_motor"})
    assert corrections.correct("left_motor", "reversed") == {"forward": 24, "backward": 23}
    assert corrections.tables["left_motor"] | {"model": 0} == {
        "driver": "h-bridge",
        "forward": 24,
        "backward": 23,
        "standby": 22,
        "model": 0,
    }
    assert corrections.tables["right_motor"]["forward"] == 17


def test_a_measured_model_stays_at_its_wheel_if_the_wires_are_swapped() -> None:
    rover = load_robot("rover")
    measured = {"dead_band": 0.2, "forward_rad_s": 12.5, "backward_rad_s": 13.0}
    section = {**rover.backends["raspberrypi"]}
    section["left_motor"] = {**section["left_motor"], "model": measured}
    robot = rover.model_copy(update={"backends": {**rover.backends, "raspberrypi": section}})
    corrections = Corrections(robot, load_backend("virtualpi"))
    assert corrections.swap({"left_motor": "right_motor", "right_motor": "left_motor"})
    left, right = (corrections.tables[f"{side}_motor"] for side in ("left", "right"))
    assert (left["forward"], right["forward"]) == (23, 17)
    assert left["model"] == measured
    assert right["model"] != measured


def test_two_corrections_of_a_mistake_cancel_each_other(corrections: Corrections) -> None:
    for _ in range(2):
        corrections.correct("left_encoder", "reversed")
    assert corrections.tables == {}


def test_a_mistake_that_no_setting_corrects_changes_nothing(corrections: Corrections) -> None:
    assert corrections.correct("nose", "reversed") is None
    assert corrections.correct("screen", "reversed") is None
    assert not corrections.swap({"screen": "eye", "eye": "screen"})
    assert corrections.tables == {}


def test_a_simulator_has_no_tables_to_correct() -> None:
    corrections = Corrections(load_robot("rover"), load_backend("kinematic"))
    assert corrections.section is None
    assert corrections.correct("left_motor", "reversed") is None
    assert not corrections.swap({"left_motor": "right_motor", "right_motor": "left_motor"})


def test_values_of_a_description_are_collected(corrections: Corrections) -> None:
    corrections.correct_description("pan", {"min_angle_rad": -0.8})
    corrections.correct_description("pan", {"max_angle_rad": 0.9})
    assert corrections.values == {"pan": {"min_angle_rad": -0.8, "max_angle_rad": 0.9}}
