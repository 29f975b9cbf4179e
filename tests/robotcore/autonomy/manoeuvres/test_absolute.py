"""Where go_to, follow_path and face end, and what they refuse."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from robotcore import BlockedError, Outcome, Robot, Routine, face, follow_path, go_to, straight, turn
from robotcore.errors import UnmetNeedError, UsageError
from robotcore.geometry import Pose
from robotcore.testing import MockRobot
from tests.robotcore.autonomy.manoeuvres.driving import Drive, drive
from tests.texts import CheckText, Raises

CORNERS = [(1.0, 0.0), (1.8, 0.4), (1.8, 1.2), (0.5, 1.0)]


def measure_distance(done: Drive, point: tuple[float, float]) -> float:
    """Return the least distance of the way from a point, in metres."""
    start = done.way.poses[0]
    return min(math.dist(start.to_local(pose.x, pose.y), point) for pose in done.way.poses)


@pytest.mark.parametrize("robot", ["rover", "freenove-4wd", "picar"])
@pytest.mark.parametrize("point", [(0.8, 0.5), (-0.6, 0.2), (0.7, 0.0), (0.0, -0.9)])
def test_go_to_ends_at_the_point(point: tuple[float, float], robot: str) -> None:
    done = drive(lambda robot: go_to(robot, *point), robot=robot)
    assert math.dist(done.end[:2], point) < 0.003
    assert math.dist(done.returned[:2], point) < 0.003


def test_points_are_in_the_frame_of_the_odometry() -> None:
    def route(robot: Robot) -> Routine[None]:
        yield from straight(robot, 0.4)
        yield from go_to(robot, 0.4, 0.5)
        yield from go_to(robot, 0.0, 0.0)
        yield from face(robot, 0.0)

    done = drive(route)
    assert math.dist(done.end[:2], (0.0, 0.0)) < 0.003
    assert abs(done.end.heading) < 0.005


@pytest.mark.parametrize("robot", ["rover", "freenove-4wd"])
def test_path_passes_each_corner_within_1_cm(robot: str) -> None:
    done = drive(lambda robot: follow_path(robot, CORNERS), robot=robot)
    assert all(measure_distance(done, point) < 0.015 for point in CORNERS)
    assert measure_distance(done, CORNERS[-1]) < 0.002


def test_a_robot_that_steers_rounds_corners() -> None:
    done = drive(lambda robot: follow_path(robot, CORNERS), robot="picar")
    assert math.dist(done.end[:2], CORNERS[-1]) < 0.005
    assert all(measure_distance(done, point) < 0.17 for point in CORNERS)


def test_gentle_corners_do_not_stop_the_robot() -> None:
    circle = [
        (0.6 * math.sin(turn), 0.6 - 0.6 * math.cos(turn)) for turn in (each * math.pi / 10 for each in range(1, 20))
    ]
    done = drive(lambda robot: follow_path(robot, circle))
    start = done.way.poses[0]
    assert all(abs(math.dist(start.to_local(pose.x, pose.y), (0.0, 0.6)) - 0.6) < 0.02 for pose in done.way.poses)
    stops = sum(sent == (0.0, 0.0) for sent in done.sent)
    assert stops < 15


def test_points_that_repeat_or_lie_on_a_line_are_allowed() -> None:
    points = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.0), (0.4, 0.0), (0.4, 0.3), (0.4, 0.0)]
    done = drive(lambda robot: follow_path(robot, points))
    assert math.dist(done.end[:2], points[-1]) < 0.002


def test_going_to_the_present_place_ends_at_once() -> None:
    done = drive(lambda robot: go_to(robot, -0.002, 0.0))
    assert len(done.way.records) == 1


@pytest.mark.parametrize("heading, turned", [(3.0, 3.0), (-3.0, -3.0), (3.5, 3.5 - math.tau), (0.0, 0.0)])
def test_face_turns_the_shorter_way(heading: float, turned: float) -> None:
    assert drive(lambda robot: face(robot, heading)).returned.heading == pytest.approx(turned, abs=0.005)


def test_speed_and_turn_rate_are_not_exceeded() -> None:
    done = drive(lambda robot: go_to(robot, 0.0, 0.5, speed=0.1, turn_rate=0.5))
    assert max((sent.left + sent.right) / 2 * 0.0325 for sent in done.sent) < 0.101
    assert max((sent.right - sent.left) * 0.0325 / 0.155 for sent in done.sent) < 0.51


def test_a_blocked_path_reports_the_whole_way_that_remains(check_text: CheckText) -> None:
    done = drive(lambda robot: follow_path(robot, [(0.2, 0.0), (3.0, 0.0), (3.0, 4.0)]), world="arena")
    error = done.result.error
    assert isinstance(error, BlockedError)
    assert done.result.outcome is Outcome.FAILURE
    assert error.cause == "range-guard"
    assert 4.0 < error.remaining_m < 7.0
    check_text(error)


def open_robot(name: str = "rover") -> Robot:
    return MockRobot(name).layered


@pytest.mark.parametrize("value", [float("nan"), 101.0, "1"])
def test_a_coordinate_that_is_no_sensible_number_is_refused(value: float, raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", argument="x"):
        go_to(open_robot(), value, 0.0)
    with raises(UsageError, "manoeuvre-argument", argument="y"):
        follow_path(open_robot(), [(1.0, 0.0), (1.0, value)])
    with raises(UsageError, "manoeuvre-argument", argument="y"):
        go_to(open_robot("picar"), 0.0, value)


@pytest.mark.parametrize("points", [[], None, 5, "ab", [(1.0,)], [(1.0, 2.0, 3.0)], [1.0, 2.0]])
def test_points_that_are_no_pairs_are_refused(points: list[tuple[float, float]], raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", argument="points"):
        follow_path(open_robot(), points)


def test_speeds_that_the_drive_cannot_reach_are_refused(raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", argument="speed"):
        go_to(open_robot(), 1.0, 0.0, speed=0.0)
    with raises(UsageError, "manoeuvre-argument", argument="turn_rate"):
        follow_path(open_robot(), [(1.0, 0.0)], turn_rate=99.0)
    with raises(UsageError, "manoeuvre-argument", argument="heading"):
        face(open_robot(), float("inf"))


def test_a_heading_in_degrees_is_refused(raises: Raises) -> None:
    with raises(UsageError, "manoeuvre-argument", argument="heading"):
        face(open_robot(), 90.0)


def test_a_robot_can_face_the_heading_after_many_turns() -> None:
    def route(robot: Robot) -> Routine[Pose]:
        for _ in range(2):
            yield from turn(robot, 14.0)
        return (yield from face(robot, robot.drive.pose.heading + 1.0))

    done = drive(route)
    assert done.returned.heading == pytest.approx(29.0, abs=0.02)


def test_a_robot_that_steers_cannot_face(raises: Raises) -> None:
    with raises(UsageError, "cannot-turn-on-spot", manoeuvre="face"):
        face(open_robot("picar"), 1.0)


def test_a_point_inside_the_turning_circle_is_refused(raises: Raises) -> None:
    with raises(UsageError, "point-too-near", x_m=0.0, y_m=0.2):
        go_to(open_robot("picar"), 0.0, 0.2)


def test_a_corner_that_is_too_sharp_for_a_robot_that_steers_is_refused(raises: Raises) -> None:
    with raises(UsageError, "turn-too-sharp", x_m=1.0, y_m=0.0):
        follow_path(open_robot("picar"), [(1.0, 0.0), (1.0, 0.3), (0.0, 0.3)])


@pytest.mark.parametrize("build", [lambda r: go_to(r, 1.0, 0.0), lambda r: follow_path(r, [(1.0, 0.0)])])
def test_a_robot_without_a_drive_is_refused(build: Callable[[Robot], object]) -> None:
    with pytest.raises(UnmetNeedError):
        build(open_robot("lookout"))
