"""What ends a manoeuvre early: the range guard, a bumper, and wheels that do not turn."""

from __future__ import annotations

import math
import pickle

import pytest

from robotcore import BlockedError, Outcome, Robot, Routine, straight, turn
from robotcore.kinds import Bumper
from robotcore.testing import MockRobot
from tests.robotcore.autonomy.manoeuvres.driving import RoutineApp, drive
from tests.texts import CheckText

STUCK = {"left_encoder": 0.0, "right_encoder": 0.0}


def test_range_guard_ends_the_manoeuvre_in_front_of_an_obstacle(check_text: CheckText) -> None:
    result = drive(lambda robot: straight(robot, 5.0), world="arena").result
    error = result.error
    assert isinstance(error, BlockedError)
    assert (error.cause, error.kind, dict(error.fields)) == (
        "range-guard",
        "blocked",
        {"manoeuvre": "straight(5)", "cause": "range-guard", "remaining_m": error.remaining_m},
    )
    assert 4.0 < error.remaining_m < 5.0
    assert result.intervention_s == {"range guard": pytest.approx(0.6, abs=0.11)}
    check_text(error)


def test_a_run_that_is_blocked_is_a_failure_with_its_reason() -> None:
    result = drive(lambda robot: straight(robot, 5.0), world="arena").result
    assert (result.outcome, result.exit_status, result.reason) == (Outcome.FAILURE, 1, str(result.error))


def test_a_pressed_bumper_in_front_ends_the_manoeuvre_and_stops_the_wheels(check_text: CheckText) -> None:
    done = drive(lambda robot: straight(robot, 5.0), world="arena", robot="tracer")
    assert isinstance(done.result.error, BlockedError)
    assert done.result.error.cause == "contact"
    check_text(done.result.error)


def test_a_pressed_bumper_does_not_prevent_driving_away() -> None:
    def route(robot: Robot) -> Routine[object]:
        with pytest.raises(BlockedError):
            yield from straight(robot, 5.0)
        assert any(bumper.read().is_pressed for bumper in robot.all(Bumper))
        yield from straight(robot, -0.2)
        return (yield from turn(robot, 1.0))

    done = drive(route, world="arena", robot="tracer")
    assert done.result.outcome is Outcome.SUCCESS
    assert done.end.heading == pytest.approx(1.0, abs=0.01)


def test_wheels_that_do_not_turn_end_the_manoeuvre(check_text: CheckText) -> None:
    robot = MockRobot(readings=STUCK)
    with pytest.raises(BlockedError) as caught:
        robot.run(RoutineApp(lambda robot: straight(robot, 1.0)), ticks=100)
    assert caught.value.cause == "wheels"
    assert caught.value.remaining_m == 1.0
    assert len(robot.ticks) < 25
    assert robot.commands["left_motor"][-1].velocity == 0.0
    check_text(caught.value)


def test_wheels_that_do_not_turn_end_a_turn(check_text: CheckText) -> None:
    robot = MockRobot(readings=STUCK)
    with pytest.raises(BlockedError) as caught:
        robot.run(RoutineApp(lambda robot: turn(robot, -1.0)), ticks=100)
    assert (caught.value.cause, caught.value.remaining_rad) == ("wheels", 1.0)
    assert dict(caught.value.fields) == {"manoeuvre": "turn(-1)", "cause": "wheels", "remaining_rad": 1.0}
    check_text(caught.value)


def test_wheels_that_stall_while_a_bumper_is_pressed_are_a_contact() -> None:
    robot = MockRobot("tracer", readings={**STUCK, "left_bumper": True})
    with pytest.raises(BlockedError) as caught:
        robot.run(RoutineApp(lambda robot: turn(robot, 1.0)), ticks=100)
    assert caught.value.cause == "contact"


def test_a_blocked_error_survives_pickling() -> None:
    error = BlockedError("turn(1)", "wheels", remaining_rad=math.pi)
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301
    assert (str(copy), copy.cause, copy.remaining_rad) == (str(error), "wheels", math.pi)


def test_slow_progress_is_no_stall() -> None:
    done = drive(lambda robot: straight(robot, 0.05, speed=0.01))
    assert done.result.outcome is Outcome.SUCCESS
    assert done.end.x == pytest.approx(0.05, abs=0.002)


def test_a_turn_reports_no_range_guard() -> None:
    assert drive(lambda robot: turn(robot, 7.0), world="arena").result.outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_a_turn_after_a_stop_by_the_range_guard_ends_at_its_angle() -> None:
    def route(robot: Robot) -> Routine[object]:
        with pytest.raises(BlockedError):
            yield from straight(robot, 6.0)
        return (yield from turn(robot, math.pi / 2))

    done = drive(route, world="arena", randomise=True, seed=1)
    assert done.result.outcome is Outcome.SUCCESS
    assert done.returned.heading == pytest.approx(math.pi / 2, abs=0.01)


def test_an_app_can_catch_the_error_and_drive_another_way() -> None:
    def route(robot: Robot) -> Routine[object]:
        try:
            yield from straight(robot, 5.0)
        except BlockedError:
            yield from turn(robot, math.pi)
        return (yield from straight(robot, 0.3))

    done = drive(route, world="arena")
    assert done.result.outcome is Outcome.SUCCESS
    assert done.sent[-1] == (0.0, 0.0)
