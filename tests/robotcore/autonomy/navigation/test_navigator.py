from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from robotcore.autonomy.navigation import Navigator, StopPoint
from robotcore.autonomy.navigation.mapping import NavigationMap
from robotcore.geometry import Pose, Twist
from tests.robotcore.autonomy.navigation.map_drawing import HERE, mark_occupied, mark_unknown
from tests.robotcore.fakes import Rig

SPEED, TURN = 0.25, 1.5
BALL = StopPoint(1.4, 0.0, 0.5)


@pytest.fixture
def navigator(field: NavigationMap) -> Navigator:
    """Return a navigator in an open field."""
    navigator = Navigator(SPEED, TURN)
    navigator.forget(HERE)
    navigator.map.ground.reach = field.ground.reach
    navigator.map.grid.evidence[:] = field.grid.evidence
    navigator.map.coverage.seen[:] = True
    return navigator


def run_motion(move: Callable[[Pose], Twist | None], pose: Pose) -> list[Pose]:
    """Move with exact motion until the navigator returns None. Return the poses."""
    poses = [pose]
    while (twist := move(poses[-1])) and len(poses) < 2000:
        poses.append(poses[-1].advance(twist.linear / 20, twist.angular / 20))
    return poses


def test_without_a_plan_a_look_or_a_survey_there_is_nothing_to_do(navigator: Navigator) -> None:
    assert navigator.follow(HERE) is navigator.look(HERE) is navigator.survey(HERE) is None


class TestLook:
    def test_ends_when_the_camera_has_seen_it(self, navigator: Navigator) -> None:
        navigator.map.coverage.seen[navigator.map.grid.disc(-1.0, 0.2, 0.4)] = False
        navigator.begin_look(HERE)

        def look(pose: Pose) -> Twist | None:
            navigator.map.coverage.add_view(pose, 1.0)
            return navigator.look(pose)

        assert 2.0 < run_motion(look, HERE)[-1].heading < 3.2


class TestView:
    def test_drives_to_a_view_of_unseen_area(self, navigator: Navigator) -> None:
        mark_occupied(navigator.map.grid, 0.5, 0.6, -1.0, 1.0)
        hidden = navigator.map.grid.disc(1.2, 0.0, 0.4)
        navigator.map.coverage.seen[hidden] = False
        assert navigator.plan_to_view(HERE)
        end = run_motion(navigator.follow, HERE)[-1]
        navigator.map.coverage.add_view(end, 6.3)
        assert navigator.map.coverage.seen[hidden].mean() > 0.5
        assert not navigator.is_at_frontier

    def test_gives_up_a_view_that_was_seen_on_the_way(self, navigator: Navigator) -> None:
        mark_occupied(navigator.map.grid, 0.5, 0.6, -1.0, 1.0)
        navigator.map.coverage.seen[navigator.map.grid.disc(1.2, 0.0, 0.4)] = False
        assert navigator.plan_to_view(HERE)
        assert navigator.follow(HERE)
        navigator.map.coverage.seen[:] = True
        assert navigator.follow(HERE) is None

    def test_seen_area_does_not_end_the_path_to_a_target(self, navigator: Navigator) -> None:
        mark_occupied(navigator.map.grid, -0.6, -0.5, -1.0, 1.0)
        navigator.map.coverage.seen[navigator.map.grid.disc(-1.2, 0.0, 0.4)] = False
        assert navigator.plan_to_view(HERE)
        navigator.map.coverage.seen[:] = True
        assert navigator.plan_to(HERE, BALL)
        assert navigator.follow(HERE)

    def test_area_that_stays_unseen_from_here_is_marked_as_seen(self, navigator: Navigator) -> None:
        navigator.map.coverage.seen[navigator.map.grid.disc(0.0, 0.9, 0.3)] = False
        assert not navigator.plan_to_view(HERE)


class TestWayToTarget:
    def test_path_leads_round_an_obstacle(self, navigator: Navigator) -> None:
        mark_occupied(navigator.map.grid, 0.5, 0.6, -0.4, 0.4)
        assert not navigator.is_straight(HERE, BALL)
        assert navigator.plan_to(HERE, BALL)
        assert navigator.is_straight(run_motion(navigator.follow, HERE)[-1], BALL)

    def test_path_leads_to_another_place(self, navigator: Navigator) -> None:
        here = Pose(0.7, 0.0, 0.0)
        assert navigator.plan_to(here, BALL)
        assert run_motion(navigator.follow, here)[-1].distance_to(*here[:2]) > 0.1

    def test_ends_at_the_frontier(self, navigator: Navigator) -> None:
        mark_unknown(navigator.map.grid, 0.7, 2.0, -2.0, 2.0)
        assert navigator.plan_to(HERE, BALL)
        assert 0.2 < run_motion(navigator.follow, HERE)[-1].x < 0.7
        assert navigator.is_at_frontier
        navigator.plan_to_view(HERE)
        assert not navigator.is_at_frontier


class TestSurvey:
    def test_turns_over_the_direction_of_the_unknown_part(self, navigator: Navigator) -> None:
        mark_unknown(navigator.map.grid, -0.5, 0.5, 0.7, 2.0)
        navigator.plan_to(HERE, StopPoint(0.0, 1.6, 0.5))
        end = run_motion(navigator.follow, HERE)[-1]
        navigator.survey_ahead(end)
        headings = [pose.heading for pose in run_motion(navigator.survey, end)]
        assert max(headings) - min(headings) > 1.2
        assert (max(headings) + min(headings)) / 2 == pytest.approx(math.pi / 2, abs=0.5)

    def test_continues_with_a_full_turn_and_then_ends(self, navigator: Navigator) -> None:
        assert navigator.survey_more(HERE)
        assert abs(run_motion(navigator.survey, HERE)[-1].heading) < 1.0
        assert navigator.survey_more(HERE)
        assert run_motion(navigator.survey, HERE)[-1].heading > 6.0
        assert not navigator.survey_more(HERE)

    def test_starts_again_at_another_position(self, navigator: Navigator) -> None:
        assert navigator.survey_more(HERE)
        assert navigator.survey_more(HERE)
        assert navigator.survey_more(Pose(1.0, 0.0, 0.0))

    def test_unknown_cells_beside_the_robot_need_a_survey(self, navigator: Navigator) -> None:
        mark_unknown(navigator.map.grid, 0.25, 0.35, 0.05, 0.2)
        assert not navigator.is_straight(HERE, BALL)
        navigator.survey_ahead(HERE)
        assert navigator.is_straight(HERE, BALL)
        assert not navigator.is_known_straight(HERE, BALL)


class TestDriveAt:
    def test_drives_backward_from_a_near_target_unless_the_way_is_blocked(self, navigator: Navigator) -> None:
        near = Pose(1.0, 0.0, 0.0)
        twist = navigator.drive_at(near, BALL)
        assert twist
        assert twist.linear < 0
        mark_occupied(navigator.map.grid, 0.75, 0.8, -0.2, 0.2)
        assert navigator.drive_at(near, BALL) is None


class TestMap:
    def test_forget_starts_a_new_map_at_the_robot(self, navigator: Navigator) -> None:
        assert navigator.plan_to(HERE, BALL)
        navigator.survey_ahead(HERE)
        navigator.forget(Pose(4.0, 0.0, 0.0))
        assert navigator.follow(HERE) is navigator.survey(HERE) is None
        assert not navigator.map.grid.free.any()
        assert navigator.map.grid.is_within(9.0, 0.0, 0.5)

    def test_robot_that_leaves_the_map_gets_a_new_one(self, navigator: Navigator) -> None:
        far = Pose(20.0, -20.0, 1.0)
        navigator.observe(Rig().robot, far)
        assert navigator.map.grid.free[navigator.map.grid.cell_of(far.x, far.y)]

    def test_a_small_drive_keeps_it(self, navigator: Navigator) -> None:
        known = navigator.map
        navigator.observe(Rig().robot, Pose(1.0, 0.0, 0.0))
        assert navigator.map is known
        assert navigator.map.ground.reach == Rig().robot.drive.reach
