"""Routines, and the functions that compose them. A routine is a generator that yields once per tick."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack
from math import inf
from typing import Any, NamedTuple, TypeAlias, TypeVar

from robotcore.autonomy.pending_routine import name_routine, require_not_ended, warn_if_dropped
from robotcore.errors import RoutineTimeoutError, UsageError
from robotcore.geometry import to_number
from robotcore.hal.robot import Robot

__all__ = [
    "RaceResult",
    "Routine",
    "on_stop",
    "parallel",
    "race",
    "repeat",
    "sequence",
    "until",
    "wait",
    "wait_until",
    "with_timeout",
]

T = TypeVar("T")

Routine: TypeAlias = Generator[None, None, T]
"""A generator whose ``yield`` ends a tick, and that returns a result. ``yield from`` runs it in an app's ``run``."""

TIME_TOLERANCE_S = 1e-9
"""A deadline is reached if less than this time is left, because ticks add rounding errors."""


class RaceResult(NamedTuple):
    """The result of `race`.

    >>> import robotcore
    >>> from robotcore import race, straight, wait
    >>> with robotcore.open("rover", world="open") as robot:
    ...     ended = robot.run(race(straight(robot, 5.0), wait(robot, 0.5)))
    ...     ended.winner, ended.result
    (1, None)
    """

    winner: int
    """The position of the routine that ended first, from 0."""
    result: Any
    """The result of that routine."""


@warn_if_dropped
def wait(robot: Robot, seconds: float) -> Routine[None]:
    """Wait for a time. The robot stops if no other routine drives it, because a velocity is in force for a few ticks.

    robot: the robot, for its clock.
    seconds: the time, in seconds.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(wait(robot, 0.5))
    ...     robot.clock.now()
    0.5
    """
    time = _require_time("wait", seconds)

    def run() -> Routine[None]:
        deadline = robot.clock.now() + time - TIME_TOLERANCE_S
        while robot.clock.now() < deadline:
            yield

    return run()


@warn_if_dropped
def wait_until(condition: Callable[[], object]) -> Routine[None]:
    """Wait until ``condition()`` is true. It is called once per tick. The robot stops as in `wait`.

    condition: a function without arguments.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(wait_until(lambda: robot.clock.now() >= 0.3))
    ...     robot.clock.now()
    0.3
    """
    _require_condition("wait_until", condition)

    def run() -> Routine[None]:
        while not condition():
            yield

    return run()


@warn_if_dropped
def sequence(*routines: Routine[Any]) -> Routine[tuple[Any, ...]]:
    """Run routines one after another. Return their results.

    routines: the routines, such as ``straight(robot, 1.0)``.

    >>> from robotcore import straight, turn
    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     poses = robot.run(sequence(straight(robot, 0.2), turn(robot, 1.0)))
    ...     [round(pose.heading) for pose in poses]
    [0, 1]
    """
    routines = take_generators("sequence", routines)

    def run() -> Routine[tuple[Any, ...]]:
        results = []
        with _closing(routines):
            for routine in routines:
                results.append((yield from routine))  # noqa: PERF401  a comprehension cannot contain `yield from`
        return tuple(results)

    return run()


@warn_if_dropped
def parallel(*routines: Routine[Any]) -> Routine[tuple[Any, ...]]:
    """Run routines at the same time, until all have ended. Return their results.

    Each tick advances them in their order. Of two commands to one device, the last one holds.

    routines: the routines, such as ``straight(robot, 1.0)``.

    >>> import robotcore
    >>> from robotcore import move, wait
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(parallel(move(robot, 0.2, seconds=0.5), wait(robot, 1.0)))
    ...     robot.clock.now()
    (None, None)
    1.0
    """
    routines = take_generators("parallel", routines)

    def run() -> Routine[tuple[Any, ...]]:
        results: dict[int, Any] = {}
        with _closing(routines):
            while True:
                for index, routine in enumerate(routines):
                    if index not in results:
                        has_ended, result = _advance(routine)
                        if has_ended:
                            results[index] = result
                if len(results) == len(routines):
                    return tuple(results[index] for index in range(len(routines)))
                yield

    return run()


@warn_if_dropped
def race(*routines: Routine[Any]) -> Routine[RaceResult]:
    """Run routines at the same time, until the first has ended. Close the others, and return the winner.

    Each tick advances them in their order. If two end in the same tick, the first in this order wins.

    routines: the routines, such as ``straight(robot, 1.0)``.

    >>> import robotcore
    >>> from robotcore import move, wait
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(race(move(robot, 0.2), wait(robot, 0.5))).winner  # the motion was closed
    ...     robot.clock.now()
    1
    0.5
    """
    routines = take_generators("race", routines, least=1)

    def run() -> Routine[RaceResult]:
        with _closing(routines):
            while True:
                for index, routine in enumerate(routines):
                    has_ended, result = _advance(routine)
                    if has_ended:
                        return RaceResult(index, result)
                yield

    return run()


@warn_if_dropped
def repeat(build: Callable[[], Routine[Any]], times: int | None = None) -> Routine[None]:
    """Run a routine again and again. Each repetition takes at least one tick.

    build: a function that returns a new routine, because a generator runs once.
    times: the number of repetitions. None repeats until the run ends.

    >>> from robotcore import turn
    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(repeat(lambda: turn(robot, 0.5), times=2))
    ...     round(robot.drive.pose.heading, 1)
    1.0
    """
    if not callable(build):
        text = f"repeat needs a function that builds a routine, not {_format(build)}"
        text += ". Write repeat(lambda: straight(robot, 1.0), 4)"
        raise UsageError(text, kind="not-a-function")
    if times is not None and (not isinstance(times, int) or times < 0):
        text = f"times is {times!r:.100}; it must be a whole number, or None"
        raise UsageError(text, kind="wrong-times", times=times)

    def run() -> Routine[None]:
        for _ in itertools.count() if times is None else range(times):
            (routine,) = take_generators("repeat", [build()])
            with _closing([routine]):
                while not _advance(routine)[0]:
                    yield
            yield

    return run()


@warn_if_dropped
def with_timeout(robot: Robot, seconds: float, routine: Routine[T]) -> Routine[T]:
    """Run a routine, and return its result. Close it if it takes longer than a time.

    robot: the robot, for its clock.
    seconds: the longest time, in seconds.
    routine: the routine, such as ``straight(robot, 1.0)``.

    Raises RoutineTimeoutError, which is a TimeoutError, if the routine takes longer.

    >>> import robotcore
    >>> from robotcore import straight
    >>> with robotcore.open("rover", world="open") as robot:
    ...     try:
    ...         robot.run(with_timeout(robot, 0.5, straight(robot, 5.0)))
    ...     except TimeoutError:
    ...         print(f"too slow: it is {robot.clock.now()} s")
    too slow: it is 0.5 s
    """
    time = _require_time("with_timeout", seconds)
    (routine,) = take_generators("with_timeout", [routine])

    def run() -> Routine[T]:
        deadline = robot.clock.now() + time - TIME_TOLERANCE_S
        with _closing([routine]):
            while robot.clock.now() < deadline:
                has_ended, result = _advance(routine)
                if has_ended:
                    return result  # type: ignore[no-any-return]
                yield
            text = f"{name_routine(routine)} took longer than {time:g} s"
            text += ". Give it more seconds, or catch RoutineTimeoutError"
            raise RoutineTimeoutError(text, seconds=time)

    return run()


@warn_if_dropped
def until(condition: Callable[[], object], routine: Routine[Any]) -> Routine[bool]:
    """Run a routine until ``condition()`` is true, and close it then. Return whether the condition was true.

    The condition is called in each tick before the routine. The result is False if the routine ended by itself.

    condition: a function without arguments.
    routine: the routine, such as ``move(robot, 0.2)``.

    >>> from robotcore import move
    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(until(lambda: robot.drive.pose.x > 0.1, move(robot, 0.2)))  # whether the condition was true
    True
    """
    _require_condition("until", condition)
    (routine,) = take_generators("until", [routine])

    def run() -> Routine[bool]:
        with _closing([routine]):
            while not condition():
                if _advance(routine)[0]:
                    return False
                yield
        return True

    return run()


@warn_if_dropped
def on_stop(routine: Routine[T], clean_up: Callable[[], object]) -> Routine[T]:
    """Run a routine, and return its result. Call ``clean_up`` when it ends, fails or is closed.

    A run closes its routine when its time is over, and after an error or a signal. It does not if the app hangs.

    routine: the routine.
    clean_up: a function without arguments.

    >>> import robotcore
    >>> from robotcore import wait
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.run(on_stop(wait(robot, 0.1), lambda: print("the light is off")))
    the light is off
    """
    (routine,) = take_generators("on_stop", [routine])
    _require_condition("on_stop", clean_up)

    def run() -> Routine[T]:
        try:
            with _closing([routine]):
                return (yield from routine)
        finally:
            clean_up()

    return run()


def _advance(routine: Routine[Any]) -> tuple[bool, Any]:
    """Run a routine until the end of its tick. Return whether it has ended, and its result."""
    try:
        yielded: object = next(routine)
    except StopIteration as end:
        return True, end.value
    require_plain_yield(routine, yielded)
    return False, None


def require_plain_yield(routine: Routine[Any], yielded: object) -> None:
    """Raise UsageError if a routine has yielded a value."""
    if yielded is not None:
        remedy = "Write yield from in front of it" if isinstance(yielded, Generator) else "Write yield alone"
        text = f"{name_routine(routine)} yields {_format(yielded)}. {remedy}: one yield ends a tick"
        raise UsageError(text, kind="yields-a-value")


def _closing(routines: Sequence[Routine[Any]]) -> ExitStack:
    """Return a context that closes routines at its end, in reverse order, so that their clean-up runs."""
    stack = ExitStack()
    for routine in routines:
        stack.callback(routine.close)
    return stack


def _format(value: object) -> str:
    return f"the routine {name_routine(value)}" if isinstance(value, Generator) else f"{value!r:.100}"


def take_generators(function: str, routines: Sequence[object], least: int = 0) -> tuple[Routine[Any], ...]:
    """Return the generators of routines, which the caller runs or closes. Their `PendingRoutine` does not warn then.

    function: the name of the function that gets the routines.
    least: the least number of routines.

    Raises UsageError if a value is no routine, or a routine that has ended.
    """
    if len(routines) < least:
        raise UsageError(f"{function} needs a routine, such as straight(robot, 1.0)", kind="no-routine")
    generators = tuple(_take_generator(function, each) for each in routines)
    if len(set(generators)) < len(generators):
        raise UsageError(f"{function} has a routine twice. Build a new one for each place", kind="routine-twice")
    return generators


def _take_generator(function: str, routine: object) -> Routine[Any]:
    if not isinstance(routine, Generator):
        text = f"{function} needs routines, such as straight(robot, 1.0), not {routine!r:.100}"
        hint = ". Call it, or call its run(robot)" if callable(getattr(routine, "run", routine)) else ""
        raise UsageError(text + hint, kind="not-a-routine")
    generator: Routine[Any] = iter(routine)
    require_not_ended(generator)
    return generator


def _require_condition(function: str, condition: object) -> None:
    if not callable(condition):
        text = f"{function} needs a function, such as a lambda, not {condition!r:.100}"
        raise UsageError(text, kind="not-a-function")


def _require_time(function: str, seconds: float) -> float:
    time = to_number(seconds)
    if not 0 <= time < inf:
        text = f"{function} needs a time in seconds, not {seconds!r:.100}. Give a finite number, 0 or more"
        raise UsageError(text, kind="wrong-time", seconds=seconds)
    return time
