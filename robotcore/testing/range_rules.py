"""Rules for range sensors: distances, limits, the cone, and lost echoes."""

from __future__ import annotations

import math

import pytest

from robotcore.description import RangeSensorDescription, WorldDescription
from robotcore.hal.devices import Range
from robotcore.hal.robot import Role
from robotcore.testing import worlds
from robotcore.testing.bench import TestBench, TestSupport, sleep

TOLERANCE_M = 0.01
TOUCH_M = 0.0005
NARROW_RAD = 0.05


class RangeRules(TestBench):
    """The rules for range sensors."""

    @property
    def sensor(self) -> RangeSensorDescription:
        """The description of the robot's first range sensor."""
        found = self.description.first_of(RangeSensorDescription)
        return found or pytest.skip(f"{self.description.name} has no range sensor")

    @pytest.mark.parametrize("distance", [0.3, 0.7, 1.5])
    def test_distance_to_a_wall_is_right(self, distance: float) -> None:
        if not self.sensor.min_range_m <= distance <= self.sensor.max_range_m:
            pytest.skip(f"{self.sensor.name} measures {self.sensor.min_range_m} to {self.sensor.max_range_m} m")
        got = self._read_range(worlds.wall(self.sensor.mount, distance)).distance
        assert got == pytest.approx(distance, abs=TOLERANCE_M), (
            f"a wall {distance} m in front of {self.sensor.name} reads {got:.3f} m; expected within {TOLERANCE_M} m"
        )

    def test_nothing_ahead_reads_inf(self) -> None:
        got = self._read_range(worlds.empty()).distance
        assert got == math.inf, f"open ground reads {got} m; nothing in range must read inf"

    def test_beyond_the_maximum_reads_inf(self) -> None:
        distance = self.sensor.max_range_m + 0.2
        got = self._read_range(worlds.wall(self.sensor.mount, distance)).distance
        assert got == math.inf, (
            f"a wall at {distance} m, beyond max_range {self.sensor.max_range_m} m, reads {got}; expected inf"
        )

    def test_nearer_than_the_minimum_reads_the_minimum(self) -> None:
        minimum = self.sensor.min_range_m
        self._require_reachable(minimum / 2)
        got = self._read_range(worlds.wall(self.sensor.mount, minimum / 2)).distance
        assert got == pytest.approx(minimum), f"a wall at {minimum / 2} m reads {got}; expected min_range, {minimum} m"

    def test_touching_a_wall_does_not_read_inf(self) -> None:
        gap = self.description.body.front_x_m - self.sensor.mount.x_m + TOUCH_M
        self._require_reachable(gap)
        got = self._read_range(worlds.wall(self.sensor.mount, gap)).distance
        assert math.isfinite(got), (
            f"a wall at the robot's nose reads {got}; let rays begin inside the body, else they begin behind the wall"
        )

    def test_cone_is_the_full_angle(self) -> None:
        away, half = self._reach, self._half_cone
        inside = self._read_range(worlds.post(self.sensor.mount, away, 0.75 * half)).distance
        outside = self._read_range(worlds.post(self.sensor.mount, away, 1.25 * half + 0.1)).distance
        assert inside == pytest.approx(away, abs=2 * TOLERANCE_M), (
            f"a post {away} m away, inside the cone on its left, reads {inside}; cone_rad is the full angle"
        )
        assert outside == math.inf, (
            f"a post {away} m away, left of the cone, reads {outside}; cone_rad is the full angle"
        )

    def test_detected_point_is_left_positive(self) -> None:
        point = self._read_range(worlds.post(self.sensor.mount, self._reach, 0.75 * self._half_cone)).point
        if point is None:
            pytest.skip("its samples have no detected point")
        assert point[0] > 0 < point[1], (
            f"a post ahead on the left was detected at {point} in the sensor's frame; x is forward, y to the left"
        )

    def test_limits_equal_the_description(self) -> None:
        described = self.sensor
        with self.open_robot(None, Role.RANGE) as robot:
            got = (robot.range.min_range, robot.range.max_range, robot.range.cone)
        expected = (described.min_range_m, described.max_range_m, described.cone_rad)
        assert got == pytest.approx(expected), f"min_range, max_range, cone are {got}; the description says {expected}"

    def test_lost_echo_makes_no_new_sample(self) -> None:
        self.require(TestSupport.LOST_ECHO)
        with self.open_robot(worlds.wall(self.sensor.mount, self._reach), Role.RANGE) as robot:
            before = robot.range.read()
            self.lose_echoes(robot)
            sleep(robot, 0.5)
            after = robot.range.read()
        assert (after.distance, after.time, after.sequence) == (before.distance, before.time, before.sequence), (
            f"after 0.5 s without an echo, read() gave {after}; the last sample was {before}. A lost echo is no new "
            "sample: return the last sample with its time and sequence, never inf or the last distance as a new one"
        )

    @property
    def _half_cone(self) -> float:
        half = self.sensor.cone_rad / 2
        return (
            half
            if half > NARROW_RAD
            else pytest.skip(f"{self.sensor.name} is a beam, whose cone is too narrow to test")
        )

    @property
    def _reach(self) -> float:
        """A distance well within the sensor's range, in metres."""
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
                f"{self.sensor.name} is mounted so that no obstacle in front of the body comes within {distance} m"
            )
