"""A routine that warns if a statement drops it before it has begun, because ``yield from`` is missing."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Generator
from contextlib import suppress
from functools import wraps
from inspect import GEN_CLOSED, getgeneratorstate
from opcode import opname
from types import FrameType, GeneratorType
from typing import Any, ParamSpec, TypeVar
from weakref import finalize

from robotcore.errors import UsageError

P = ParamSpec("P")
T = TypeVar("T")


class PendingRoutine(Generator[None, None, T]):
    """A routine that a call has built. It begins when ``yield from``, ``robot.run`` or a composition takes it.

    A call that is a whole statement drops its routine. The routine then never runs, so Python prints a RuntimeWarning.
    ``yield from`` calls ``__iter__``, and continues with the generator itself. So a tick costs no more.

    routine: the generator.
    name: the name of the function that has built it.
    """

    def __init__(self, routine: Generator[None, None, T], name: str) -> None:
        self._routine = routine
        self.__qualname__ = name  # a generator has it too
        self._warning = finalize(self, _warn_if_dropped_by_statement, name)

    def __iter__(self) -> Generator[None, None, T]:
        """Return the generator. Raises UsageError if it has ended, because ``yield from`` would do nothing."""
        require_not_ended(self._routine)
        return self._take()

    def __next__(self) -> None:
        return next(self._take())

    def send(self, value: None) -> None:
        return self._take().send(value)

    def throw(self, *error: Any) -> None:
        return self._take().throw(*error)

    def close(self) -> None:
        self._take().close()

    def _take(self) -> Generator[None, None, T]:
        self._warning.detach()
        return self._routine

    def __repr__(self) -> str:
        name = self.__qualname__
        return f"<routine {name}, not run yet. {_format_remedy(name)}>" if self._warning.alive else f"<routine {name}>"


def warn_if_dropped(function: Callable[P, Generator[None, None, T]]) -> Callable[P, Generator[None, None, T]]:
    """Decorate a function that builds a routine. Python prints a RuntimeWarning if a statement drops the routine."""
    name = function.__qualname__.rpartition("<locals>.")[2]

    @wraps(function)
    def build(*arguments: P.args, **named: P.kwargs) -> Generator[None, None, T]:
        routine = iter(function(*arguments, **named))  # the generator of a PendingRoutine
        routine.__qualname__ = name  # type: ignore[attr-defined]  # the function may return an inner generator
        return PendingRoutine(routine, name)

    return build


def require_not_ended(routine: Generator[Any, Any, Any]) -> None:
    """Raise UsageError if a generator has ended."""
    if isinstance(routine, GeneratorType) and getgeneratorstate(routine) == GEN_CLOSED:
        text = f"the routine {name_routine(routine)} has already ended. Build a new one for each run"
        raise UsageError(text, kind="routine-ended")


def name_routine(routine: Generator[Any, Any, Any]) -> str:
    """Return the name of the function that built a routine.

    A function such as `sequence` checks its arguments, and returns an inner generator. The name is the function's.
    """
    return getattr(routine, "__qualname__", type(routine).__name__).partition(".<locals>")[0]


def _warn_if_dropped_by_statement(name: str) -> None:
    with suppress(ValueError):  # a thread without a Python function has no such frame
        if _drops_call(sys._getframe(2)):  # noqa: SLF001  the caller of `finalize.__call__`, as for `stacklevel`
            warnings.warn(f"the routine {name} was never run. {_format_remedy(name)}", RuntimeWarning, stacklevel=3)


def _drops_call(frame: FrameType) -> bool:
    """Return whether a frame drops the value of a call, because the call is a whole statement.

    The instruction POP_TOP follows such a call. An exception, and the end of a run or a loop, drop values elsewhere.
    From Python 3.12, a comprehension that is a whole statement has no such call.
    """
    code, index = frame.f_code.co_code, frame.f_lasti
    before = (code[each] for each in range(index - 2, -1, -2))
    call = next(filter(None, before), 0)  # opcode 0 is the cache of an instruction
    return opname[code[index]] == "POP_TOP" and opname[call].startswith("CALL")


def _format_remedy(name: str) -> str:
    call = f"{name.rpartition('.')[2]}(...)"
    return f"Write yield from {call} in a behaviour, or robot.run({call}) at a prompt"
