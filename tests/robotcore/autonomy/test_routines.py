"""Routines are advanced once per tick. Each way out of a composition closes its routines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robotcore.autonomy.routines import (
    RaceResult,
    Routine,
    on_stop,
    parallel,
    race,
    repeat,
    sequence,
    until,
    wait,
    wait_until,
    with_timeout,
)
from robotcore.errors import RoutineTimeoutError, UsageError
from robotcore.testing import MockRobot
from tests.texts import Raises


class Log:
    """Builds routines that take some ticks, and records their ticks and their ends."""

    def __init__(self) -> None:
        self.events: list[str] = []

    def routine(self, name: str, ticks: int) -> Routine[str]:
        try:
            for tick in range(ticks):
                self.events.append(f"{name}{tick}")
                yield
            return name
        finally:
            self.events.append(f"{name}.")

    def fail(self, name: str) -> Routine[str]:
        yield
        raise ValueError(name)


@pytest.fixture
def log() -> Log:
    return Log()


def drive(routine: Routine[Any], robot: MockRobot | None = None) -> tuple[int, Any]:
    """Run a routine to its end. Return the number of its ticks and its result."""
    ticks = 0
    while True:
        try:
            next(routine)
        except StopIteration as end:
            return ticks, end.value
        ticks += 1
        if robot:
            robot.advance()


def test_sequence_runs_one_routine_after_another(log: Log) -> None:
    assert drive(sequence(log.routine("a", 2), log.routine("b", 1))) == (3, ("a", "b"))
    assert log.events == ["a0", "a1", "a.", "b0", "b."]


def test_parallel_ends_with_the_last_routine(log: Log) -> None:
    assert drive(parallel(log.routine("a", 1), log.routine("b", 3))) == (3, ("a", "b"))
    assert log.events == ["a0", "b0", "a.", "b1", "b2", "b."]


def test_race_ends_with_the_first_routine_and_closes_the_other(log: Log) -> None:
    assert drive(race(log.routine("a", 5), log.routine("b", 1))) == (1, RaceResult(1, "b"))
    assert log.events == ["a0", "b0", "a1", "b.", "a."]


@pytest.mark.parametrize("compose", [parallel, race, sequence])
def test_failure_closes_the_other_routines(log: Log, compose: Callable[..., Routine[Any]]) -> None:
    with pytest.raises(ValueError, match="broken"):
        drive(compose(log.routine("a", 1 if compose is sequence else 5), log.fail("broken"), log.routine("c", 5)))
    assert "a." in log.events


def test_repeat_builds_the_routine_anew(log: Log) -> None:
    assert drive(repeat(lambda: log.routine("a", 1), 2)) == (4, None)
    assert log.events == ["a0", "a.", "a0", "a."]


def test_endless_repeat_of_nothing_still_yields(log: Log) -> None:
    routine = repeat(lambda: log.routine("a", 0))
    for _ in range(3):
        next(routine)
    assert log.events == ["a."] * 3


def test_wait_takes_its_time() -> None:
    robot = MockRobot()
    assert drive(wait(robot.layered, 1.0), robot) == (20, None)


@pytest.mark.parametrize("second", [np.float32(1.0), np.int64(1)])
def test_numpy_numbers_are_times(second: Any) -> None:
    robot = MockRobot()
    assert drive(wait(robot.layered, second), robot) == (20, None)
    assert drive(with_timeout(robot.layered, second, wait(robot.layered, 0.1)), robot) == (2, None)


def test_wait_until_ends_when_its_condition_is_true() -> None:
    answers = iter([False, False, True])
    assert drive(wait_until(lambda: next(answers))) == (2, None)


def test_timeout_closes_the_routine(log: Log, raises: Raises) -> None:
    robot = MockRobot()
    with raises(RoutineTimeoutError, "routine-timeout", seconds=0.1):
        drive(with_timeout(robot.layered, 0.1, log.routine("a", 9)), robot)
    assert log.events == ["a0", "a1", "a."]


def test_routine_that_is_fast_enough_returns_its_result(log: Log) -> None:
    robot = MockRobot()
    assert drive(with_timeout(robot.layered, 0.1, log.routine("a", 1)), robot) == (1, "a")


def test_until_closes_its_routine_when_its_condition_is_true(log: Log) -> None:
    assert drive(until(lambda: len(log.events) == 2, log.routine("a", 9))) == (2, True)
    assert log.events == ["a0", "a1", "a."]


def test_until_is_false_if_its_routine_ends_first(log: Log) -> None:
    assert drive(until(lambda: False, log.routine("a", 2))) == (2, False)


@pytest.mark.parametrize("ticks", [0, 1, 5], ids=["unstarted", "closed", "ended"])
def test_clean_up_runs_on_each_way_out(log: Log, ticks: int) -> None:
    routine = on_stop(log.routine("a", 3), lambda: log.events.append("clean"))
    for _ in range(ticks):
        next(routine, None)
    routine.close()
    assert log.events.count("clean") == (ticks > 0)


def test_clean_up_runs_after_a_failure(log: Log) -> None:
    with pytest.raises(ValueError, match="broken"):
        drive(on_stop(log.fail("broken"), lambda: log.events.append("clean")))
    assert log.events == ["clean"]


def yield_three() -> Any:
    yield 3


def yield_routine() -> Any:
    yield yield_three()


def ended() -> Routine[None]:
    return drive_to_end(wait_until(lambda: True))


def drive_to_end(routine: Routine[None]) -> Routine[None]:
    drive(routine)
    return routine


NOTHING: Any = None
FUNCTION: Any = yield_three
TEXT: Any = "1"
TRUE: Any = True
FRACTION: Any = 1.5

BAD: dict[str, tuple[Callable[[Any], Any], str]] = {
    "a number": (lambda _: drive(race(yield_three())), "yields-a-value"),
    "yield without from": (lambda _: drive(parallel(yield_routine())), "yields-a-value"),
    "no routine": (lambda _: race(), "no-routine"),
    "a function": (lambda _: sequence(FUNCTION), "not-a-routine"),
    "a text": (lambda _: parallel(TEXT), "not-a-routine"),
    "an ended routine": (lambda _: sequence(ended()), "routine-ended"),
    "NaN": (lambda robot: wait(robot, float("nan")), "wrong-time"),
    "a negative time": (lambda robot: with_timeout(robot, -1.0, yield_three()), "wrong-time"),
    "a text as time": (lambda robot: wait(robot, TEXT), "wrong-time"),
    "a bool as time": (lambda robot: wait(robot, TRUE), "wrong-time"),
    "a number beyond floats": (lambda robot: wait(robot, 10**400), "wrong-time"),
    "no condition": (lambda _: wait_until(TRUE), "not-a-function"),
    "a routine to repeat": (lambda _: repeat(yield_three()), "not-a-function"),
    "a fraction": (lambda _: repeat(yield_three, FRACTION), "wrong-times"),
    "nothing built": (lambda _: drive(repeat(lambda: NOTHING, 1)), "not-a-routine"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_argument_is_refused(raises: Raises, case: str) -> None:
    call, kind = BAD[case]
    with raises(UsageError, kind, hide=[] if case != "a function" else [repr(yield_three)[22:]]):
        call(MockRobot().layered)


def test_one_routine_at_two_places_is_refused(raises: Raises, log: Log) -> None:
    routine = log.routine("a", 1)
    with raises(UsageError, "routine-twice"):
        parallel(routine, routine)
