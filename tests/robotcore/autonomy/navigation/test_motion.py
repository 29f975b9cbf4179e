from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation.mapping import NavigationMap
from robotcore.autonomy.navigation.motion import BACK_M_S, CameraLook, Follower, SensorSurvey, Steering
from robotcore.autonomy.navigation.planner import GridPath
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.map_drawing import HERE, REACH, mark_occupied

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


@pytest.mark.parametrize(
    "bearing, away, velocity",
    [
        (1.0, 1.0, (0.0, TURN)),
        (-1.0, 1.0, (0.0, -TURN)),
        (0.0, 1.0, (SPEED, 0.0)),
        (0.0, 0.15, (0.8 * SPEED, 0.0)),
        (0.0, 0.0, (0.3 * SPEED, 0.0)),
    ],
)
def test_a_robot_on_a_path_turns_first_and_slows_down_at_the_end(
    steering: Steering, bearing: float, away: float, velocity: tuple[float, float]
) -> None:
    assert steering.steer(bearing, away) == pytest.approx(velocity)


@pytest.mark.parametrize(
    "bearing, gap, velocity",
    [
        (0.0, 1.0, (SPEED, 0.0)),
        (0.0, 0.05, (0.075, 0.0)),
        (0.0, -0.5, (-BACK_M_S, 0.0)),
        (0.2, 1.0, (SPEED, 0.5)),
        (0.4, 1.0, (0.0, 1.0)),
    ],
)
def test_a_robot_approaches_a_target_straight_and_slowly(
    steering: Steering, bearing: float, gap: float, velocity: tuple[float, float]
) -> None:
    assert steering.approach(bearing, gap) == pytest.approx(velocity)


class TestFollower:
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

    def test_drives_at_the_lookahead_point(self, follower: Follower, field: NavigationMap) -> None:
        start, corner, end = (field.grid.cell_of(*point) for point in ((0.0, 0.0), (0.8, 0.0), (0.8, 0.8)))
        steer = [(start[0], column) for column in range(start[1], corner[1])]
        up = [(row, corner[1]) for row in range(corner[0], end[0])]
        follower.start(GridPath(steer + up, field.grid.free))
        twist = follower.follow(HERE)
        assert twist
        assert twist.angular == pytest.approx(0.0, abs=0.2)


def run_camera_scan(scan: CameraLook, headings: list[float]) -> float:
    """Turn from 0 in steps of 0.1 rad until no bearing is left, and return the turn."""
    heading = 0.0
    for _ in range(200):
        bearings = np.array([(at - heading + math.pi) % math.tau - math.pi for at in headings])
        if not (sense := scan.turn_direction(heading, bearings)):
            break
        heading += 0.1 * sense
        headings = [at for at in headings if abs((at - heading + math.pi) % math.tau - math.pi) > 0.15]
    return heading


def run_sensor_scan(scan: SensorSurvey, heading: float) -> list[float]:
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
        assert run_camera_scan(CameraLook(0.0), [-0.5, 0.8]) == pytest.approx(0.8 - math.tau, abs=0.2)
        assert run_camera_scan(CameraLook(0.0), [0.5, -0.8]) == pytest.approx(math.tau - 0.8, abs=0.2)

    def test_ends_after_one_full_turn(self) -> None:
        scan = CameraLook(0.0)
        heading, bearing = 0.0, np.array([0.3])
        while scan.turn_direction(heading, bearing) and heading < 20:
            heading += 0.1
        assert heading == pytest.approx(math.tau - 0.3, abs=0.1)

    def test_turning_back_counts_as_turning_too(self) -> None:
        scan = CameraLook(0.0)
        senses = [scan.turn_direction(heading, np.array([0.5])) for heading in [0.0, 1.0] * 4]
        assert senses == [1.0] * 6 + [0.0] * 2


class TestSensorScan:
    def test_scans_both_sides_of_a_bearing_the_nearer_first(self) -> None:
        assert run_sensor_scan(SensorSurvey.ahead(HERE, 0.3), 0.0) == pytest.approx([-0.5, 1.1], abs=0.12)
        assert run_sensor_scan(SensorSurvey.ahead(HERE, -0.3), 0.0) == pytest.approx([0.5, -1.1], abs=0.12)

    def test_full_turn_ends_at_the_first_heading(self) -> None:
        assert run_sensor_scan(SensorSurvey.full_turn(Pose(0.0, 0.0, 1.0)), 1.0) == pytest.approx(
            [1.0 + math.tau], abs=0.12
        )

    def test_is_near_its_own_place_only(self) -> None:
        scan = SensorSurvey.ahead(HERE, 0.0)
        assert scan.is_near(Pose(0.1, 0.0, 2.0), REACH)
        assert not scan.is_near(Pose(0.2, 0.0, 0.0), REACH)
