"""A routine that a statement drops before it has begun causes a warning. No other routine does."""

from __future__ import annotations

import _thread
import gc
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import robotcore
from robotcore import (
    Behaviour,
    Robot,
    Role,
    Routine,
    RunRequest,
    Status,
    arc,
    face,
    follow_path,
    go_to,
    move,
    on_stop,
    parallel,
    race,
    repeat,
    run,
    sequence,
    straight,
    turn,
    until,
    wait,
    wait_until,
    with_timeout,
)
from robotcore.autonomy import navigation
from robotcore.autonomy.navigation import BallTracker, Navigator, StopPoint, drive_to, explore, turn_to
from robotcore.autonomy.pending_routine import name_routine
from robotcore.errors import UsageError
from robotcore.testing import MockRobot
from tests.texts import CheckText, Raises

CALLS: dict[str, Callable[[Robot], Routine[Any]]] = {
    "arc": lambda robot: arc(robot, 1.0, 1.0),
    "BallTracker.watch": lambda robot: BallTracker("green", 0.1).watch(robot),
    "drive_to": lambda robot: drive_to(robot, Navigator(0.2, 1.0), StopPoint(1.0, 0.0, 0.3)),
    "explore": lambda robot: explore(robot, Navigator(0.2, 1.0)),
    "face": lambda robot: face(robot, 1.0),
    "follow_path": lambda robot: follow_path(robot, [(1.0, 0.0)]),
    "go_to": lambda robot: go_to(robot, 1.0, 0.0),
    "move": lambda robot: move(robot, 0.1),
    "on_stop": lambda robot: on_stop(wait(robot, 1.0), lambda: None),
    "parallel": lambda robot: parallel(wait(robot, 1.0), wait(robot, 1.0)),
    "race": lambda robot: race(wait(robot, 1.0), wait(robot, 1.0)),
    "repeat": lambda robot: repeat(lambda: wait(robot, 1.0)),
    "sequence": lambda robot: sequence(wait(robot, 1.0), wait(robot, 1.0)),
    "straight": lambda robot: straight(robot, 1.0),
    "turn": lambda robot: turn(robot, 1.0),
    "turn_to": lambda robot: turn_to(robot, Navigator(0.2, 1.0), StopPoint(1.0, 0.0, 0.3)),
    "until": lambda robot: until(lambda: False, wait(robot, 1.0)),
    "wait": lambda robot: wait(robot, 1.0),
    "wait_until": lambda robot: wait_until(lambda: False),
    "with_timeout": lambda robot: with_timeout(robot, 1.0, wait(robot, 1.0)),
}


@pytest.fixture
def robot() -> Robot:
    return MockRobot().layered


@pytest.fixture
def warned() -> Iterator[list[warnings.WarningMessage]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield caught


def line_of(function: Callable[..., object], offset: int) -> int:
    return function.__code__.co_firstlineno + offset


def test_each_public_routine_is_tested() -> None:
    public = {name: getattr(module, name) for module in (robotcore, navigation) for name in module.__all__}
    public |= {"BallTracker.watch": BallTracker.watch}
    results = {name: getattr(each, "__annotations__", {}).get("return", "") for name, each in public.items()}
    assert set(CALLS) == {name for name, result in results.items() if str(result).startswith("Routine")}


@pytest.mark.parametrize("name", CALLS)
def test_routine_that_a_statement_drops_causes_one_warning(
    name: str, robot: Robot, warned: list[warnings.WarningMessage]
) -> None:
    call = CALLS[name]

    def forget() -> None:
        call(
            robot,
        )

    forget()
    (warning,) = warned
    assert warning.category is RuntimeWarning
    assert (warning.filename, warning.lineno) == (__file__, line_of(forget, 1))
    written = name.rpartition(".")[2]
    assert str(warning.message).startswith(f"the routine {name} was never run. Write yield from {written}(...) in")


@pytest.mark.parametrize("name", CALLS)
def test_generator_has_the_name_of_the_function(name: str, robot: Robot) -> None:
    assert name_routine(iter(CALLS[name](robot))) == name


class Other(Behaviour):
    """An app that contains its parts."""

    def run(self, robot: Robot) -> Routine[Status]:
        yield from self.pause(robot)
        return Status.SUCCESS

    def pause(self, robot: Robot) -> Routine[None]:
        yield from wait(robot, 0.1)


class Stepping(Behaviour):
    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


@pytest.mark.parametrize("part", ["run", "pause", "step"])
def test_routine_of_an_app_that_a_statement_drops_causes_a_warning(
    part: str, robot: Robot, warned: list[warnings.WarningMessage], check_text: CheckText
) -> None:
    call = Stepping().run if part == "step" else getattr(Other(), part)

    def forget() -> Routine[None]:
        call(robot)
        yield from wait(robot, 0.1)

    next(forget())
    (warning,) = warned
    assert warning.lineno == line_of(forget, 1)
    check_text(warning.message)


def test_warning_names_the_statement_that_calls_a_helper(robot: Robot, warned: list[warnings.WarningMessage]) -> None:
    def nod() -> Routine[None]:
        return wait(robot, 1.0)

    def forget() -> None:
        nod()

    forget()
    assert [each.lineno for each in warned] == [line_of(forget, 1)]


def test_app_without_yield_from_runs_with_a_warning(warned: list[warnings.WarningMessage]) -> None:
    class Forgetful(Behaviour):
        needs = frozenset({Role.DRIVE})

        def run(self, robot: Robot) -> Routine[Status]:
            straight(robot, 0.5)
            yield from wait(robot, 0.1)
            return Status.SUCCESS

    assert run(RunRequest(Forgetful, world="open")).outcome.value == "success"
    assert [str(each.message)[:34] for each in warned] == ["the routine straight was never run"]


def take_first(first: Routine[Any], second: Routine[Any], is_second_needed: bool) -> Routine[None]:
    yield from first
    if is_second_needed:
        yield from second


def end_early(robot: Robot) -> Routine[None]:
    before = wait(robot, 0.0)
    after = turn(robot, 1.0)
    yield from before
    yield from take_first(wait(robot, 0.0), turn(robot, 1.0), False)
    for routine in (wait(robot, 0.0), turn(robot, 1.0)):
        yield from routine
        break
    for routine in (wait(robot, 0.0), wait_until(lambda: True), turn(robot, 1.0)):
        yield from routine
        if routine is not before:
            return
    yield from after


def time_out(robot: Robot) -> Routine[None]:
    after = turn(robot, 1.0)
    yield from take_first(wait(robot, 9.0), turn(robot, 1.0), True)
    for routine in (after, turn(robot, 1.0)):
        yield from routine


def time_out_in_a_loop(robot: Robot) -> Routine[None]:
    for routine in (wait(robot, 9.0), turn(robot, 1.0)):
        yield from routine


def fail(robot: Robot) -> Routine[None]:
    routines = [wait(robot, 1.0), turn(robot, 1.0)]
    yield from take_first(turn(robot, 1.0), straight(robot, 1 / 0), bool(routines))


def refuse(robot: Robot) -> Routine[None]:
    no_routine: Any = 3
    yield from sequence(turn(robot, 1.0), no_routine)


def run_all(robot: Robot) -> Routine[None]:
    yield from sequence(wait(robot, 0.0), race(wait(robot, 0.0), turn(robot, 1.0)))
    with pytest.raises(TimeoutError):
        yield from with_timeout(robot, 0.0, turn(robot, 1.0))
    yield from until(lambda: True, turn(robot, 1.0))
    assert list(wait(robot, 0.0)) == []
    assert next(wait(robot, 0.0), "ended") == "ended"
    turn(robot, 1.0).close()


@pytest.mark.slow
@pytest.mark.parametrize("routine", [end_early, time_out, time_out_in_a_loop, fail, refuse, run_all])
def test_other_ends_cause_no_warning(
    routine: Callable[[Robot], Routine[None]], robot: Robot, warned: list[warnings.WarningMessage]
) -> None:
    def run_and_close() -> None:
        running = routine(robot)
        with suppress(ZeroDivisionError, UsageError):
            next(running, None)
        running.close()

    run_and_close()
    gc.collect()
    assert warned == []


def test_routine_has_the_methods_of_a_generator() -> None:
    class App(Behaviour):
        def nod(self) -> Routine[str]:
            try:
                yield
            except KeyError:
                return "caught"
            return "ended"

    first, second, third = App().nod(), App().nod(), App().nod()
    assert next(first) is None
    with pytest.raises(StopIteration, match="ended"):
        first.send(None)
    next(second)
    with pytest.raises(StopIteration, match="caught"):
        second.throw(KeyError)
    next(third)
    third.close()
    assert next(third, "closed") == "closed"


def test_second_yield_from_of_a_routine_is_refused(robot: Robot, raises: Raises) -> None:
    def run_twice() -> Routine[None]:
        pause = wait(robot, 0.0)
        yield from pause
        yield from pause

    with raises(UsageError, "routine-ended"):
        list(run_twice())


def test_function_may_return_the_routine_of_another(robot: Robot) -> None:
    class App(Behaviour):
        def rest(self) -> Routine[None]:
            return wait(robot, 0.0)

        def run(self, robot: Robot) -> Routine[Status]:
            yield from sequence(self.rest())
            return Status.SUCCESS

    assert list(App().run(robot)) == []


def test_routine_may_end_in_a_thread_without_a_python_function(robot: Robot, capfd: pytest.CaptureFixture[str]) -> None:
    threads = _thread._count()
    _thread.start_new_thread(id, (wait(robot, 1.0),))
    while _thread._count() > threads:
        time.sleep(0.01)
    assert capfd.readouterr().err == ""


def test_prompt_shows_how_to_run_a_routine(robot: Robot, check_text: CheckText) -> None:
    routine = straight(robot, 0.1)
    check_text(repr(routine))
    next(routine)
    assert repr(routine) == "<routine straight>"
    routine.close()


SCRIPT = """
import sys
from robotcore import straight, wait_until
from robotcore.errors import UsageError
from robotcore.testing import MockRobot

robot = MockRobot().layered
kept = straight(robot, 1.0)
cycle = [straight(robot, 1.0)]
cycle.append(cycle)
del cycle
sys.kept = wait_until(bool)
{call}
print("the end")
"""


@pytest.mark.slow
@pytest.mark.parametrize("options", [[], ["-W", "error"]], ids=["warning", "error"])
def test_end_of_the_program_causes_no_warning(options: list[str], tmp_path: Path) -> None:
    for call, text in {"pass": "", "straight(robot, 1.0)": "the routine straight was never run"}.items():
        script = tmp_path / "script.py"
        script.write_text(SCRIPT.format(call=call))
        ended = subprocess.run([sys.executable, *options, script], capture_output=True, text=True, check=True)
        assert ended.stdout == "the end\n"
        assert text in ended.stderr
        assert ended.stderr.count("RuntimeWarning: ") == bool(text)
