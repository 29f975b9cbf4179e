from __future__ import annotations

import math

import pytest

from robotcore.description import Mount, load_robot
from robotcore.kinds.range_sensor import RangeSensorDescription

ROVER = load_robot("rover")


def sensor(yaw: float, pitch: float) -> RangeSensorDescription:
    mount = Mount(z_m=0.1, yaw_rad=yaw, pitch_rad=pitch)
    return RangeSensorDescription(
        kind="range_sensor", name="other", mount=mount, min_range_m=0.02, max_range_m=2.0, cone_rad=0.5
    )


@pytest.mark.parametrize(
    "yaw, pitch, is_ahead",
    [(0.0, 0.0, True), (0.5, 0.0, True), (math.tau, 0.0, True), (math.pi, 0.0, False), (0.0, math.pi / 2, False)],
    ids=["ahead", "a little aside", "once round", "behind", "at the floor"],
)
def test_range_sensor_is_ahead_within_45_degrees(*, yaw: float, pitch: float, is_ahead: bool) -> None:
    robot = ROVER.model_copy(update={"devices": (sensor(yaw, pitch), *ROVER.devices)})
    assert ("other" in {each.name for each in robot.sensors_ahead}) is is_ahead
