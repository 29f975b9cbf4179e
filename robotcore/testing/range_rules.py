"""Rules for range sensors: distances, limits, the cone, and lost echoes."""

from __future__ import annotations

import math

import pytest

from robotcore.description import WorldDescription
from robotcore.hal.robot import Role
from robotcore.kinds.range_sensor import Range, RangeSensorDescription
from robotcore.testing import worlds
from robotcore.testing.bench import RATE_HZ, TestBench, TestSupport, sleep

TOLERANCE_M = 0.01
TOUCH_M = 0.0005
SPEED_RAD_S = 4.0
NARROW_RAD = 0.05


class RangeRules(TestBench):
    """Tests that the driver of every range sensor must pass."""

    @property
    def sensor(self) -> RangeSensorDescription:
        """The description of the robot's first range sensor. If there is none, the rule is skipped."""
        found = self.description.first_of(RangeSensorDescription)
        return found or pytest.skip(f"{self.description.name} has no range sensor")

    @pytest.mark.parametrize("distance", [0.3, 0.7, 1.5])
    def test_distance_to_a_wall_is_right(self, distance: float) -> None:
        if not self.sensor.min_range_m <= distance <= self.sensor.max_range_m:
            limits = f"{self.sensor.min_range_m} to {self.sensor.max_range_m} m"
            pytest.skip(f"{self.sensor.name} measures {limits}, so it cannot measure {distance} m")
        got = self._read_range(worlds.wall(self.sensor.mount, distance)).distance
        assert got == pytest.approx(distance, abs=TOLERANCE_M), (
            f"{self.sensor.name} returned {got:.3f} m for a wall {distance} m in front of it. Return the distance "
            f"in metres, within {TOLERANCE_M} m"
        )

    def test_nothing_ahead_reads_inf(self) -> None:
        got = self._read_range(worlds.empty()).distance
        assert got == math.inf, f"{self.sensor.name} returned {got} m on open ground. Return inf if nothing is in range"

    def test_beyond_the_maximum_reads_inf(self) -> None:
        distance = self.sensor.max_range_m + 0.2
        got = self._read_range(worlds.wall(self.sensor.mount, distance)).distance
        assert got == math.inf, (
            f"{self.sensor.name} returned {got} m for a wall at {distance} m. Return inf beyond max_range, "
            f"{self.sensor.max_range_m} m"
        )

    def test_nearer_than_the_minimum_reads_the_minimum(self) -> None:
        minimum = self.sensor.min_range_m
        self._require_reachable(minimum / 2)
        got = self._read_range(worlds.wall(self.sensor.mount, minimum / 2)).distance
        assert got == pytest.approx(minimum), (
            f"{self.sensor.name} returned {got} m for a wall at {minimum / 2} m. Return min_range, {minimum} m"
        )

    def test_touching_a_wall_does_not_read_inf(self) -> None:
        gap = self.description.body.front_x_m - self.sensor.mount.x_m + TOUCH_M
        self._require_reachable(gap)
        got = self._read_range(worlds.wall(self.sensor.mount, gap)).distance
        assert math.isfinite(got), (
            f"{self.sensor.name} returned {got} for a wall that almost touches the robot. Let rays begin inside the "
            "body, so that they do not begin behind the wall"
        )

    def test_cone_is_the_full_angle(self) -> None:
        away, half = self._distance_in_range_m, self._half_cone
        inside = self._read_range(worlds.post(self.sensor.mount, away, 0.75 * half)).distance
        outside = self._read_range(worlds.post(self.sensor.mount, away, 1.25 * half + 0.1)).distance
        assert inside == pytest.approx(away, abs=2 * TOLERANCE_M), (
            f"{self.sensor.name} returned {inside} m for a post at {away} m near the left edge of its cone. "
            "Detect obstacles in the whole angle cone_rad"
        )
        assert outside == math.inf, (
            f"{self.sensor.name} returned {outside} m for a post at {away} m left of its cone. "
            "Detect obstacles only in the angle cone_rad"
        )

    def test_detected_point_is_left_positive(self) -> None:
        point = self._read_range(
            worlds.post(self.sensor.mount, self._distance_in_range_m, 0.75 * self._half_cone)
        ).point
        if point is None:
            pytest.skip(f"the samples of {self.sensor.name} have no detected point")
        assert point[0] > 0 < point[1], (
            f"{self.sensor.name} detected a post ahead on the left at {point} m. Return the point in the sensor's "
            "frame, with x forward and y to the left"
        )

    def test_limits_equal_the_description(self) -> None:
        described = self.sensor
        with self.open_robot(None, Role.RANGE) as robot:
            got = (robot.range.min_range, robot.range.max_range, robot.range.cone)
        expected = (described.min_range_m, described.max_range_m, described.cone_rad)
        assert got == pytest.approx(expected), (
            f"min_range, max_range and cone are {got}. Set them to the described values, {expected}"
        )

    def test_distance_is_within_the_limits_or_inf(self) -> None:
        roles = (Role.RANGE, Role.DRIVE) if self.description.drive else (Role.RANGE,)
        with self.open_robot(worlds.wall(self.sensor.mount, self._distance_in_range_m), *roles) as robot:
            if self.description.drive:
                self.command_wheels(robot, SPEED_RAD_S, SPEED_RAD_S, seconds=0.0)
            for _ in range(round(RATE_HZ)):
                sleep(robot, 1 / RATE_HZ)
                distance = robot.range.read().distance
                assert self.sensor.min_range_m <= distance <= self.sensor.max_range_m or distance == math.inf, (
                    f"{self.sensor.name} returned {distance} m. Return a distance from {self.sensor.min_range_m} to "
                    f"{self.sensor.max_range_m} m, or inf if nothing is in range"
                )

    def test_lost_echo_makes_no_new_sample(self) -> None:
        self.require(TestSupport.LOST_ECHO)
        with self.open_robot(worlds.wall(self.sensor.mount, self._distance_in_range_m), Role.RANGE) as robot:
            before = robot.range.read()
            self.lose_echoes(robot)
            sleep(robot, 0.5)
            after = robot.range.read()
        assert (after.distance, after.time, after.sequence) == (before.distance, before.time, before.sequence), (
            f"after 0.5 s without an echo read() returned {after}. Return the last sample unchanged, {before}, "
            "because a lost echo makes no new sample"
        )

    @property
    def _half_cone(self) -> float:
        half = self.sensor.cone_rad / 2
        return half if half > NARROW_RAD else pytest.skip(f"the cone of {self.sensor.name} is too narrow to test")

    @property
    def _distance_in_range_m(self) -> float:
        """A distance that the sensor can measure, in metres."""
        return min(0.5, self.sensor.max_range_m / 2)

    def _read_range(self, world: WorldDescription) -> Range:
        self.require(TestSupport.WORLD)
        with self.open_robot(world, Role.RANGE) as robot:
            sleep(robot, 0.2)
            return robot.range.read()

    def _require_reachable(self, distance: float) -> None:
        mount, body = self.sensor.mount, self.description.body
        if mount.yaw_rad or mount.x_m + distance < body.front_x_m:
            pytest.skip(
                f"no obstacle can be {distance} m away from {self.sensor.name}, because the robot's body is in the way"
            )
