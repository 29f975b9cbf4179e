from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation.mapping import NavigationMap
from robotcore.autonomy.navigation.motion import BACK_M_S, NO_SCAN, CameraScan, Follower, SensorScan, Steering
from robotcore.autonomy.navigation.planner import GridPath
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.places import HERE, REACH, mark_occupied

SPEED, TURN = 0.25, 1.5


@pytest.fixture
def steering() -> Steering:
    return Steering(SPEED, TURN)


@pytest.fixture
def follower(field: NavigationMap, steering: Steering) -> Follower:
    return Follower(field.ground, steering)


def begin(follower: Follower, field: NavigationMap, x: float, y: float) -> None:
    follower.start(field.ground.find_path(field.grid.cell_of(0.0, 0.0), field.grid.cell_of(x, y)))


def follow_to_end(follower: Follower, pose: Pose, ticks: int = 2000) -> list[Pose]:
    """Follow the path to its end with exact motion, and return the poses."""
    poses = [pose]
    while (twist := follower.follow(poses[-1])) and len(poses) < ticks:
        poses.append(poses[-1].advance(twist.linear / 20, twist.angular / 20))
    return poses


class TestSteering:
    def test_turns_on_the_spot_to_a_large_bearing(self, steering: Steering) -> None:
        assert steering.along(1.0, 1.0) == (0.0, TURN)
        assert steering.along(-1.0, 1.0) == (0.0, -TURN)
        assert steering.along(0.0, 1.0) == (SPEED, 0.0)

    def test_slows_down_as_it_arrives_but_not_to_a_stop(self, steering: Steering) -> None:
        speeds = [steering.along(0.0, away).linear for away in (0.3, 0.1, 0.0)]
        assert SPEED == speeds[0] > speeds[1] > speeds[2] > 0

    def test_approaches_slower_the_smaller_the_gap(self, steering: Steering) -> None:
        assert steering.approach(0.0, 1.0) == (SPEED, 0.0)
        assert 0 < steering.approach(0.0, 0.05).linear < SPEED / 2

    def test_drives_slowly_backward_if_it_is_too_near(self, steering: Steering) -> None:
        assert steering.approach(0.0, -0.5).linear == -BACK_M_S

    def test_approaches_only_with_a_small_bearing(self, steering: Steering) -> None:
        linear, angular = steering.approach(0.5, 1.0)
        assert linear == 0.0
        assert angular > 0


class TestFollower:
    def test_returns_none_without_a_path(self, follower: Follower) -> None:
        assert follower.follow(HERE) is None

    def test_ends_at_the_end_of_the_path(self, follower: Follower, field: NavigationMap) -> None:
        begin(follower, field, 1.2, -0.8)
        assert follow_to_end(follower, HERE)[-1].distance_to(1.2, -0.8) < 0.08

    def test_cuts_corners_but_keeps_its_distance(self, follower: Follower, field: NavigationMap) -> None:
        mark_occupied(field.grid, 0.5, 0.6, -0.4, 0.4)
        begin(follower, field, 1.2, 0.0)
        poses = follow_to_end(follower, HERE)
        clearance = field.grid.clearance()
        assert poses[-1].distance_to(1.2, 0.0) < 0.08
        assert min(clearance[field.grid.cell_of(pose.x, pose.y)] for pose in poses) > REACH

    def test_plans_again_if_the_path_is_blocked(self, follower: Follower, field: NavigationMap) -> None:
        begin(follower, field, 1.2, 0.0)
        poses = follow_to_end(follower, HERE, ticks=20)
        mark_occupied(field.grid, 0.6, 0.7, -0.4, 0.4)
        poses = follow_to_end(follower, poses[-1])
        assert poses[-1].distance_to(1.2, 0.0) < 0.08
        assert max(abs(pose.y) for pose in poses) > 0.4

    def test_returns_none_if_no_path_is_left(self, follower: Follower, field: NavigationMap) -> None:
        begin(follower, field, 1.2, 0.0)
        mark_occupied(field.grid, 0.5, 0.6, -2.0, 2.0)
        assert follower.follow(HERE) is None

    def test_does_not_change_the_given_path(self, follower: Follower, field: NavigationMap) -> None:
        way = field.ground.find_path(field.grid.cell_of(0.0, 0.0), field.grid.cell_of(0.6, 0.0))
        length = len(way.cells)
        follower.start(way)
        follow_to_end(follower, HERE)
        assert len(way.cells) == length

    def test_drives_at_the_lookahead_point(self, follower: Follower, field: NavigationMap) -> None:
        start, corner, end = (field.grid.cell_of(*point) for point in ((0.0, 0.0), (0.8, 0.0), (0.8, 0.8)))
        along = [(start[0], column) for column in range(start[1], corner[1])]
        up = [(row, corner[1]) for row in range(corner[0], end[0])]
        follower.start(GridPath(along + up, field.grid.free))
        twist = follower.follow(HERE)
        assert twist
        assert twist.angular == pytest.approx(0.0, abs=0.2)


def run_camera_scan(scan: CameraScan, headings: list[float]) -> float:
    """Turn from 0 in steps of 0.1 rad until no bearing is left, and return the turn."""
    heading = 0.0
    for _ in range(200):
        bearings = np.array([(at - heading + math.pi) % math.tau - math.pi for at in headings])
        if not (sense := scan.turn_direction(heading, bearings)):
            break
        heading += 0.1 * sense
        headings = [at for at in headings if abs((at - heading + math.pi) % math.tau - math.pi) > 0.15]
    return heading


def run_sensor_scan(scan: SensorScan, heading: float) -> list[float]:
    """Return the headings at which the scan changes its direction, and its last heading."""
    turning_points, last = [], 0.0
    while sense := scan.turn_direction(heading):
        if sense == -last:
            turning_points.append(heading)
        last = sense
        heading += 0.02 * sense
    return [*turning_points, heading]


class TestCameraScan:
    def test_turns_to_the_nearest_bearing_and_on_in_the_same_direction(self) -> None:
        assert run_camera_scan(CameraScan(0.0), [-0.5, 0.8]) == pytest.approx(0.8 - math.tau, abs=0.2)
        assert run_camera_scan(CameraScan(0.0), [0.5, -0.8]) == pytest.approx(math.tau - 0.8, abs=0.2)

    def test_ends_without_bearings(self) -> None:
        assert run_camera_scan(CameraScan(0.0), [1.0, 2.0]) == pytest.approx(2.0, abs=0.2)
        assert CameraScan(0.0).turn_direction(0.0, np.array([])) == 0.0

    def test_ends_after_one_full_turn(self) -> None:
        scan = CameraScan(0.0)
        heading, bearing = 0.0, np.array([0.3])
        while scan.turn_direction(heading, bearing) and heading < 20:
            heading += 0.1
        assert heading == pytest.approx(math.tau - 0.3, abs=0.1)

    def test_turning_back_counts_as_turning_too(self) -> None:
        scan = CameraScan(0.0)
        senses = [scan.turn_direction(heading, np.array([0.5])) for heading in [0.0, 1.0] * 4]
        assert senses == [1.0] * 6 + [0.0] * 2


class TestSensorScan:
    def test_scans_both_sides_of_a_bearing_the_nearer_first(self) -> None:
        assert run_sensor_scan(SensorScan.ahead(HERE, 0.3), 0.0) == pytest.approx([-0.5, 1.1], abs=0.12)
        assert run_sensor_scan(SensorScan.ahead(HERE, -0.3), 0.0) == pytest.approx([0.5, -1.1], abs=0.12)

    def test_full_turn_ends_at_the_first_heading(self) -> None:
        assert run_sensor_scan(SensorScan.full_turn(Pose(0.0, 0.0, 1.0)), 1.0) == pytest.approx(
            [1.0 + math.tau], abs=0.12
        )

    def test_is_near_its_own_place_only(self) -> None:
        scan = SensorScan.ahead(HERE, 0.0)
        assert scan.is_near(Pose(0.1, 0.0, 2.0), REACH)
        assert not scan.is_near(Pose(0.2, 0.0, 0.0), REACH)

    def test_no_scan_is_near_no_place(self) -> None:
        assert not NO_SCAN.is_near(HERE, REACH)
        assert NO_SCAN.turn_direction(0.0) == 0.0
