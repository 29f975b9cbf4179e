from __future__ import annotations

import math
from typing import Any

import pytest

from robotcore import Behaviour, Outcome, Robot, Role, Routine, RunRequest, Status, race, run, until
from robotcore.autonomy.navigation import BallTracker, Navigator, StopPoint, drive_to, explore, turn_to
from robotcore.errors import RoutineError, UsageError
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.map_drawing import HERE, REACH
from tests.robotcore.fakes import UNHURRIED, Rig
from tests.texts import Raises

SPEED, TURN = 0.25, 1.5
BALL = StopPoint(1.4, 0.0, 0.5)


class ToPoint(Behaviour):
    """Drives to a target, and keeps the error of the routine."""

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})

    def __init__(self, target: StopPoint) -> None:
        self.navigator = Navigator(SPEED, TURN)
        self.error: RoutineError | None = None
        self.end = HERE
        self.farthest_m = 0.0
        self._target = target

    def run(self, robot: Robot) -> Routine[Status]:
        try:
            yield from race(self.observe(robot), drive_to(robot, self.navigator, self._target))
        except RoutineError as error:
            self.error = error
        return Status.SUCCESS

    def observe(self, robot: Robot) -> Routine[None]:
        while True:
            self.end = robot.drive.pose
            self.farthest_m = max(self.farthest_m, self.end.x)
            yield


class ToView(Behaviour):
    """Explores until it sees the ball."""

    needs = frozenset({Role.DRIVE, Role.CAMERA, Role.RANGE})

    def __init__(self) -> None:
        self.end = HERE

    def run(self, robot: Robot) -> Routine[Status]:
        ball = BallTracker("green", 0.1)
        exploring = until(lambda: ball.is_in_sight, explore(robot, Navigator(SPEED, TURN)))
        yield from race(ball.watch(robot), exploring)
        self.end = robot.drive.pose
        return Status.SUCCESS


@pytest.fixture
def rig() -> Rig:
    """Return a robot without encoders: its odometry is exact."""
    return Rig(description=UNHURRIED)


@pytest.fixture
def navigator() -> Navigator:
    """Return a navigator in a free and seen circle of 2 m."""
    navigator = Navigator(SPEED, TURN)
    navigator.map.grid.evidence[navigator.map.grid.disc(0.0, 0.0, 2.0)] = -1.0
    navigator.map.coverage.seen[:] = True
    navigator.map.ground.reach = REACH
    return navigator


def drive(rig: Rig, routine: Routine[Any], ticks: int = 2000) -> list[Pose]:
    """Run a routine to its end, or for a number of ticks. Return the robot's poses."""
    poses = [rig.robot.drive.pose]
    for _ in range(ticks):
        try:
            next(routine)
        except StopIteration:
            break
        rig.commit()
        poses.append(rig.robot.drive.pose)
    return poses


class TestTurnTo:
    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_turns_on_the_spot_to_the_target(self, rig: Rig, navigator: Navigator, side: float) -> None:
        poses = drive(rig, turn_to(rig.robot, navigator, StopPoint(0.0, side, 0.3)))
        assert poses[-1] == pytest.approx((0.0, 0.0, side * math.pi / 2), abs=0.1)
        rig.commit()
        assert rig.wheels == (0.0, 0.0)

    def test_turns_to_a_target_that_moves(self, rig: Rig, navigator: Navigator) -> None:
        def find_target() -> StopPoint:
            return StopPoint(-1.0 if rig.robot.drive.pose.heading > 1.0 else 0.0, 1.0, 0.3)

        assert drive(rig, turn_to(rig.robot, navigator, find_target))[-1].heading == pytest.approx(
            0.75 * math.pi, abs=0.1
        )

    def test_maps_the_surroundings_meanwhile(self, rig: Rig) -> None:
        navigator = Navigator(SPEED, TURN)
        drive(rig, turn_to(rig.robot, navigator, StopPoint(0.0, 1.0, 0.3)))
        assert navigator.map.grid.free[navigator.map.grid.cell_of(0.0, 1.0)]


class TestDriveTo:
    def test_stops_in_front_of_the_target_and_faces_it(self, rig: Rig, navigator: Navigator) -> None:
        target = StopPoint(0.9, 0.9, 0.4)
        end = drive(rig, drive_to(rig.robot, navigator, target))[-1]
        assert target.gap(end) == pytest.approx(0.0, abs=0.03)
        assert target.bearing(end) == pytest.approx(0.0, abs=0.1)

    def test_drives_backward_from_a_target_that_is_too_near(self, rig: Rig, navigator: Navigator) -> None:
        assert drive(rig, drive_to(rig.robot, navigator, StopPoint(0.3, 0.0, 0.5)))[-1].x < -0.1

    def test_without_a_path_surveys_the_surroundings_raises_and_begins_a_new_map(
        self, rig: Rig, navigator: Navigator, raises: Raises
    ) -> None:
        rig.nose.distance = 0.3
        walled = navigator.map
        with raises(RoutineError, "no-path", x=BALL.x, y=BALL.y):
            drive(rig, drive_to(rig.robot, navigator, BALL))
        assert rig.robot.drive.pose.heading > math.tau
        assert navigator.map is not walled

    @pytest.mark.parametrize("target", [(1.0, 0.0), None, StopPoint(math.nan, 0.0, 0.3), StopPoint(1.0, math.inf, 0.3)])
    def test_refuses_another_target_than_a_point(
        self, rig: Rig, navigator: Navigator, raises: Raises, target: Any
    ) -> None:
        for routine in (turn_to, drive_to):
            with raises(UsageError, "not-a-stop-point"):
                next(routine(rig.robot, navigator, target))
            with raises(UsageError, "not-a-stop-point"):
                next(routine(rig.robot, navigator, lambda: target))

    @pytest.mark.slow
    def test_drives_around_an_obstacle(self) -> None:
        app = ToPoint(StopPoint(-0.5, -2.7, 0.0))
        result = run(RunRequest(app))
        assert (result.outcome, result.contacts, app.error) == (Outcome.SUCCESS, 0, None)
        assert app.end.distance_to(-0.5, -2.7) < 0.03

    @pytest.mark.slow
    def test_drives_away_from_what_blocks_the_robot_and_raises(self) -> None:
        app = ToPoint(StopPoint(3.0, 0.0, 0.0))
        app.navigator.map.grid.evidence[app.navigator.map.grid.disc(0.0, 0.0, 2.0)] = -1.0
        dead = tuple(f"{motor} dead after=2 lasts=1" for motor in ("left_motor", "right_motor"))
        run(RunRequest(app, world="open", faults=dead))
        assert app.error
        assert app.error.kind == "blocked"
        assert app.farthest_m - app.end.x > 0.08
        assert not app.navigator.map.grid.free[app.navigator.map.grid.cell_of(-0.3, 0.0)]


class TestExplore:
    def test_turns_until_all_is_seen_and_then_begins_a_new_map(self, rig: Rig) -> None:
        rig.nose.distance = 0.5
        navigator = Navigator(SPEED, TURN)
        seen = navigator.map
        poses = drive(rig, until(lambda: navigator.map is not seen, explore(rig.robot, navigator)))
        assert navigator.map is not seen
        assert math.pi < abs(poses[-1].heading) < 1.1 * math.tau
        assert seen.coverage.seen[seen.grid.disc(0.0, 0.0, 0.5)].mean() > 0.9

    @pytest.mark.slow
    def test_drives_to_other_views_until_the_ball_is_in_sight(self) -> None:
        app = ToView()
        result = run(RunRequest(app, world="occluded", seed=3))
        assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0)
        assert result.sim_time_s > 10
        assert app.end.distance_to(0.0, 0.0) > 0.5
