from __future__ import annotations

from typing import Any

import pytest

from robotcore.description import Mount, load_robot, load_world, world_names
from robotcore.description.doubtful_values import find_bodies_outside, find_doubtful_values
from robotcore.kinds.lidar import LidarDescription
from tests.texts import CheckText

ROVER = load_robot("rover")


@pytest.mark.parametrize("name", ["rover", "bubblerob", "lookout"])
def test_the_shipped_robots_have_no_doubtful_values(name: str) -> None:
    assert list(find_doubtful_values(load_robot(name))) == []


@pytest.mark.parametrize(
    "part, change",
    [
        ("body", {"length_m": 25.0, "width_m": 17.0, "height_m": 9.0}),
        ("body", {"mass_kg": 900.0}),
        ("safety", {"stop_distance_m": 12.0}),
        ("drive", {"caster": {"x_m": 13.0, "radius_m": 0.01}}),
    ],
    ids=["centimetres", "grams", "stop distance", "caster"],
)
def test_a_doubtful_value_is_a_warning(part: str, change: dict[str, Any], check_text: CheckText) -> None:
    table = {**ROVER.model_dump(), part: {**getattr(ROVER, part).model_dump(), **change}}
    check_text("\n".join(find_doubtful_values(type(ROVER).model_validate(table))))


def test_a_stop_nearer_than_a_sensor_measures_is_a_warning(check_text: CheckText) -> None:
    (nose,) = ROVER.all_of("range_sensor")
    robot = ROVER.model_copy(update={"devices": (nose.model_copy(update={"min_range_m": 0.2}),)})
    check_text("\n".join(find_doubtful_values(robot)))


def test_a_sensor_slower_than_the_greatest_age_of_a_sample_is_a_warning(check_text: CheckText) -> None:
    lidar = LidarDescription(
        kind="lidar", name="scanner", mount=Mount(z_m=0.2), min_range_m=0.05, max_range_m=8.0, rate_hz=0.8
    )
    check_text("\n".join(find_doubtful_values(ROVER.model_copy(update={"devices": (lidar,)}))))


@pytest.mark.parametrize(
    "values",
    [
        {"loss": 0.2, "rate_hz": 5.0},
        {"loss": 0.6, "rate_hz": 50.0},
        {"offset_m": -0.14},
        {"offset_m": 0.3, "max_range_m": 0.35},
    ],
)
def test_errors_of_a_range_sensor_that_blind_the_range_guard_are_warnings(
    values: dict[str, float], check_text: CheckText
) -> None:
    (nose,) = ROVER.all_of("range_sensor")
    robot = ROVER.model_copy(update={"devices": (nose.model_copy(update=values),)})
    check_text("\n".join(find_doubtful_values(robot)))


def test_a_mount_far_from_the_body_is_a_warning(check_text: CheckText) -> None:
    (nose,) = ROVER.all_of("range_sensor")
    far = nose.model_copy(update={"mount": nose.mount.model_copy(update={"x_m": 18.0})})
    check_text("\n".join(find_doubtful_values(ROVER.model_copy(update={"devices": (far,)}))))


def test_degrees_and_revolutions_per_minute_are_warnings(check_text: CheckText) -> None:
    changes: dict[str, dict[str, Any]] = {
        "nose": {"mount": {"z_m": 0.1, "pitch_rad": 5.0}},
        "left_motor": {"max_velocity_rad_s": 200.0},
    }
    devices = [{**each.model_dump(), **changes.get(each.name, {})} for each in ROVER.devices]
    table = {**ROVER.model_dump(), "devices": devices}
    check_text("\n".join(find_doubtful_values(type(ROVER).model_validate(table))))


def test_a_body_beyond_the_floor_is_a_warning(check_text: CheckText) -> None:
    assert [each for name in world_names() for each in find_bodies_outside(load_world(name))] == []
    arena = load_world("arena")
    crate = next(each for each in arena.obstacles if each.shape == "box")
    long = crate.model_copy(update={"length_m": 40.0})
    check_text("\n".join(find_bodies_outside(arena.model_copy(update={"obstacles": (long,)}))))
