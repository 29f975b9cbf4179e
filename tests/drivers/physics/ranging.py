from __future__ import annotations

import math

import pytest

from robotcore.description import Mount, Start
from robotcore.kinds.range_sensor import RangeSensorDescription
from tests.drivers.physics.worlds import ROVER, EngineTests, Thing, box, post

NOSE_X = 0.14


class Ranging(EngineTests):
    """Tests of the range sensor, for every engine."""

    @pytest.mark.parametrize("distance", [0.05, 0.3, 1.9])
    def test_distance_to_a_wall_is_exact(self, distance: float) -> None:
        with self.open_robot(box(NOSE_X + distance + 0.1)) as robot:
            sample = robot.range.read()
        assert sample.distance == pytest.approx(distance, abs=1e-4)
        assert sample.point == pytest.approx((distance, 0.0, 0.0), abs=1e-4)

    def test_point_is_on_the_surface_of_the_post(self) -> None:
        start = Start(x_m=1.0, y_m=-1.0, yaw_rad=1.2)
        at = start.pose.to_world(NOSE_X + 0.5, 0.1)
        with self.open_robot(post(*at, radius=0.03), start=start) as robot:
            point = robot.range.read().point
        assert point
        assert math.hypot(point[0] - 0.5, point[1] - 0.1) == pytest.approx(0.03, abs=0.001)

    @pytest.mark.parametrize(
        "things", [[], [box(NOSE_X + 2.2)], [box(NOSE_X + 0.3, height=0.05)]], ids=["none", "far", "low"]
    )
    def test_nothing_in_range_is_inf(self, things: list[Thing]) -> None:
        with self.open_robot(*things) as robot:
            sample = robot.range.read()
        assert sample.distance == math.inf
        assert sample.point is None

    @pytest.mark.parametrize(
        "mount",
        [Mount(z_m=0.03, yaw_rad=math.pi / 2), Mount(x_m=-0.3, z_m=0.05)],
        ids=["past a wheel", "past the body"],
    )
    def test_own_body_is_not_detected(self, mount: Mount) -> None:
        moved = [
            device.model_copy(update={"mount": mount}) if isinstance(device, RangeSensorDescription) else device
            for device in ROVER.devices
        ]
        with self.open_robot(robot=ROVER.model_copy(update={"devices": tuple(moved)})) as robot:
            assert robot.range.read().distance == math.inf
