from __future__ import annotations

import pytest

from robotcore.geometry import Pose
from robotcore.navigation import Navigator

REACH = 0.17
SPEED, TURN = 0.25, 1.5
HERE = Pose(0.0, 0.0, 0.0)


@pytest.fixture
def way() -> Navigator:
    """A navigator in an open square of four metres, all of it known and looked at."""
    navigator = Navigator(SPEED, TURN)
    navigator._reach = REACH
    navigator.grid.evidence[navigator.grid.disc(0.0, 0.0, 2.0)] = -1.0
    navigator.grid.looked_at[:] = True
    return navigator


def take(way: Navigator, left: float, right: float, bottom: float, top: float) -> None:
    """Put something that is taken into the map, from x ``left`` to ``right``, from y ``bottom`` to ``top``."""
    (low, first), (high, last) = way.grid.cell_of(left, bottom), way.grid.cell_of(right, top)
    way.grid.evidence[low : high + 1, first : last + 1] = 1.0


def walk(way: Navigator, pose: Pose) -> list[Pose]:
    """Follow the plan to its end, as an ideal robot would."""
    poses = [pose]
    while (twist := way.follow(poses[-1])) and len(poses) < 2000:
        poses.append(poses[-1].advanced(twist.linear / 20, twist.angular / 20))
    return poses


def test_without_a_plan_there_is_nothing_to_follow(way: Navigator) -> None:
    assert way.follow(HERE) is None


def test_where_all_was_looked_at_there_is_no_view_to_go_to(way: Navigator) -> None:
    assert not way.plan_to_view(HERE)


def test_goes_where_it_sees_what_was_not_looked_at(way: Navigator) -> None:
    take(way, 0.5, 0.6, -1.0, 1.0)
    hidden = way.grid.disc(1.2, 0.0, 0.4)
    way.grid.looked_at[hidden] = False
    assert way.plan_to_view(HERE)
    end = walk(way, HERE)[-1]
    way.grid.add_view(end, 6.3)
    assert way.grid.looked_at[hidden].mean() > 0.5


def test_drives_round_what_stands_in_the_way_and_keeps_its_distance(way: Navigator) -> None:
    take(way, 0.5, 0.6, -0.4, 0.4)
    assert way.plan_to_ring(HERE, 1.4, 0.0, 0.5, 0.8)
    poses = walk(way, HERE)
    assert 0.45 < poses[-1].distance_to(1.4, 0.0) < 0.85
    clearance = way.grid.clearance(with_unknown=False)
    assert min(clearance[way.grid.cell_of(pose.x, pose.y)] for pose in poses) > REACH


def test_plans_only_as_far_as_is_known(way: Navigator) -> None:
    way.grid.evidence[way.grid.disc(1.4, 0.0, 0.7)] = 0.0
    assert way.plan_to_ring(HERE, 1.4, 0.0, 0.3, 0.4)
    end = walk(way, HERE)[-1]
    assert 0.2 < end.x < 0.7 - REACH + 0.05


def test_plans_anew_where_something_has_come_up(way: Navigator) -> None:
    assert way.plan_to_ring(HERE, 1.4, 0.0, 0.4, 0.5)
    take(way, 0.5, 0.6, -0.4, 0.4)
    assert walk(way, HERE)[-1].distance_to(1.4, 0.0) < 0.6


def test_gives_a_plan_up_that_nothing_leads_to_any_more(way: Navigator) -> None:
    assert way.plan_to_ring(HERE, 1.4, 0.0, 0.4, 0.5)
    take(way, 0.5, 0.6, -2.0, 2.0)
    assert way.follow(HERE) is None


class TestStraight:
    def test_open_ground_is_straight(self, way: Navigator) -> None:
        assert way.is_straight(HERE, 1.4, 0.0, 0.5, is_surveyed=False)

    def test_what_stands_between_is_in_the_way(self, way: Navigator) -> None:
        take(way, 0.5, 0.6, -0.05, 0.05)
        assert not way.is_straight(HERE, 1.4, 0.0, 0.5, is_surveyed=True)

    def test_the_target_itself_is_not_in_the_way(self, way: Navigator) -> None:
        take(way, 1.3, 1.5, -0.1, 0.1)
        assert way.is_straight(HERE, 1.4, 0.0, 0.5, is_surveyed=False)

    def test_what_is_unknown_beside_the_robot_asks_for_a_look_round(self, way: Navigator) -> None:
        way.grid.evidence[way.grid.disc(0.3, 0.1, 0.08)] = 0.0
        assert not way.is_straight(HERE, 1.4, 0.0, 0.5, is_surveyed=False)
        assert way.is_straight(HERE, 1.4, 0.0, 0.5, is_surveyed=True)


def test_turns_first_towards_what_is_far_aside(way: Navigator) -> None:
    assert way.towards(1.0, SPEED) == (0.0, TURN)
    assert way.towards(0.0, SPEED) == (SPEED, 0.0)


def test_begins_a_new_map_when_it_forgets(way: Navigator) -> None:
    assert way.plan_to_ring(HERE, 1.4, 0.0, 0.4, 0.5)
    way.forget()
    assert way.follow(HERE) is None
    assert not way.grid.free.any()
