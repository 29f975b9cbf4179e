from __future__ import annotations

import math

import pytest

from robotcore.description import Mount, RangeSensorDescription, Start
from tests.drivers.physics.worlds import ROVER, OnAnEngine, Thing, ball, box, drive, post

NOSE_X = 0.14


class Ranging(OnAnEngine):
    """Tests of the range sensor, for every engine."""

    @pytest.mark.parametrize("distance", [0.05, 0.3, 1.9])
    def test_a_wall_is_as_far_as_it_is(self, distance: float) -> None:
        with self.opened(box(NOSE_X + distance + 0.1)) as robot:
            sample = robot.range.read()
        assert sample.distance == pytest.approx(distance, abs=1e-4)
        assert sample.point == pytest.approx((distance, 0.0, 0.0), abs=1e-4)

    def test_the_point_lies_on_the_thing_in_the_sensors_frame(self) -> None:
        start = Start(x_m=1.0, y_m=-1.0, yaw_rad=1.2)
        at = start.pose.to_world(NOSE_X + 0.5, 0.1)
        with self.opened(post(*at, radius=0.03), start=start) as robot:
            point = robot.range.read().point
        assert point
        assert math.hypot(point[0] - 0.5, point[1] - 0.1) == pytest.approx(0.03, abs=0.001)

    def test_touching_reads_the_least_range(self) -> None:
        with self.opened(box(NOSE_X + 0.1)) as robot:
            assert robot.range.read().distance == robot.range.min_range == 0.02

    @pytest.mark.parametrize(
        "things", [[], [box(NOSE_X + 2.2)], [box(NOSE_X + 0.3, height=0.05)]], ids=["none", "far", "low"]
    )
    def test_nothing_in_range_is_inf(self, things: list[Thing]) -> None:
        with self.opened(*things) as robot:
            sample = robot.range.read()
        assert sample.distance == math.inf
        assert sample.point is None

    @pytest.mark.parametrize(
        "mount",
        [Mount(z_m=0.03, yaw_rad=math.pi / 2), Mount(x_m=-0.3, z_m=0.05)],
        ids=["past a wheel", "past the body"],
    )
    def test_the_robot_itself_is_left_out(self, mount: Mount) -> None:
        moved = [
            device.model_copy(update={"mount": mount}) if isinstance(device, RangeSensorDescription) else device
            for device in ROVER.devices
        ]
        with self.opened(robot=ROVER.model_copy(update={"devices": tuple(moved)})) as robot:
            assert robot.range.read().distance == math.inf

    def test_a_ball_is_seen_where_it_is_nearest(self) -> None:
        with self.opened(ball(NOSE_X + 0.6)) as robot:
            assert robot.range.read().distance == pytest.approx(0.5, abs=1e-3)

    def test_what_is_beside_the_cone_is_not_heard(self) -> None:
        with self.opened(post(NOSE_X + 0.5, 0.35)) as robot:
            assert robot.range.read().distance == math.inf

    def test_one_instant_has_one_sample_and_the_next_a_new_one(self) -> None:
        with self.opened(box(1.0)) as robot:
            first, again = robot.range.read(), robot.range.read()
            drive(robot, 5.0, 5.0, 0.5)
            later = robot.range.read()
        assert first is again
        assert (first.time, later.time) == (0.0, 0.5)
        assert later.sequence == first.sequence + 1
        assert later.distance < first.distance
