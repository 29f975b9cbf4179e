from __future__ import annotations

import pytest

from robotcore.autonomy.navigation.following import BACK_M_S, Follower, Steering
from robotcore.autonomy.navigation.ground import Way
from robotcore.autonomy.navigation.mapping import Map
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.places import HERE, REACH, take

SPEED, TURN = 0.25, 1.5


@pytest.fixture
def steering() -> Steering:
    return Steering(SPEED, TURN)


@pytest.fixture
def follower(field: Map, steering: Steering) -> Follower:
    return Follower(field.ground, steering)


def begin(follower: Follower, field: Map, x: float, y: float) -> None:
    follower.start(field.ground.way_to(field.grid.cell_of(0.0, 0.0), field.grid.cell_of(x, y)))


def walk(follower: Follower, pose: Pose, ticks: int = 2000) -> list[Pose]:
    """Follow the way to its end, as an ideal robot would."""
    poses = [pose]
    while (twist := follower.follow(poses[-1])) and len(poses) < ticks:
        poses.append(poses[-1].advanced(twist.linear / 20, twist.angular / 20))
    return poses


class TestSteering:
    def test_turns_first_to_what_is_far_aside(self, steering: Steering) -> None:
        assert steering.along(1.0, 1.0) == (0.0, TURN)
        assert steering.along(-1.0, 1.0) == (0.0, -TURN)
        assert steering.along(0.0, 1.0) == (SPEED, 0.0)

    def test_slows_down_as_it_arrives_but_not_to_a_stop(self, steering: Steering) -> None:
        speeds = [steering.along(0.0, away).linear for away in (0.3, 0.1, 0.0)]
        assert SPEED == speeds[0] > speeds[1] > speeds[2] > 0

    def test_approaches_slower_the_less_there_is_to_go(self, steering: Steering) -> None:
        assert steering.approach(0.0, 1.0) == (SPEED, 0.0)
        assert 0 < steering.approach(0.0, 0.05).linear < SPEED / 2

    def test_backs_off_slowly_where_it_is_too_near(self, steering: Steering) -> None:
        assert steering.approach(0.0, -0.5).linear == -BACK_M_S

    def test_approaches_only_what_it_is_turned_to(self, steering: Steering) -> None:
        linear, angular = steering.approach(0.5, 1.0)
        assert linear == 0.0
        assert angular > 0


class TestFollower:
    def test_without_a_way_there_is_nothing_to_follow(self, follower: Follower) -> None:
        assert follower.follow(HERE) is None

    def test_ends_where_the_way_ends(self, follower: Follower, field: Map) -> None:
        begin(follower, field, 1.2, -0.8)
        assert walk(follower, HERE)[-1].distance_to(1.2, -0.8) < 0.08

    def test_cuts_short_but_keeps_its_distance(self, follower: Follower, field: Map) -> None:
        take(field.grid, 0.5, 0.6, -0.4, 0.4)
        begin(follower, field, 1.2, 0.0)
        poses = walk(follower, HERE)
        clearance = field.grid.clearance()
        assert poses[-1].distance_to(1.2, 0.0) < 0.08
        assert min(clearance[field.grid.cell_of(pose.x, pose.y)] for pose in poses) > REACH

    def test_finds_another_way_where_something_has_come_up(self, follower: Follower, field: Map) -> None:
        begin(follower, field, 1.2, 0.0)
        poses = walk(follower, HERE, ticks=20)
        take(field.grid, 0.6, 0.7, -0.4, 0.4)
        poses = walk(follower, poses[-1])
        assert poses[-1].distance_to(1.2, 0.0) < 0.08
        assert max(abs(pose.y) for pose in poses) > 0.4

    def test_gives_up_where_nothing_leads_there_any_more(self, follower: Follower, field: Map) -> None:
        begin(follower, field, 1.2, 0.0)
        take(field.grid, 0.5, 0.6, -2.0, 2.0)
        assert follower.follow(HERE) is None

    def test_the_way_it_was_given_stays_as_it_was(self, follower: Follower, field: Map) -> None:
        way = field.ground.way_to(field.grid.cell_of(0.0, 0.0), field.grid.cell_of(0.6, 0.0))
        length = len(way.path)
        follower.start(way)
        walk(follower, HERE)
        assert len(way.path) == length

    def test_drives_at_what_is_ahead_on_its_way_not_at_its_end(self, follower: Follower, field: Map) -> None:
        start, corner, end = (field.grid.cell_of(*point) for point in ((0.0, 0.0), (0.8, 0.0), (0.8, 0.8)))
        along = [(start[0], column) for column in range(start[1], corner[1])]
        up = [(row, corner[1]) for row in range(corner[0], end[0])]
        follower.start(Way(along + up, field.grid.free))
        twist = follower.follow(HERE)
        assert twist
        assert twist.angular == pytest.approx(0.0, abs=0.2)
