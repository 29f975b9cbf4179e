"""The open robots of the program. The end of the program closes them."""

from __future__ import annotations

import atexit
import gc
import os
from collections.abc import Callable
from threading import get_ident
from typing import Any, NamedTuple
from weakref import ref


class _OpenRobot(NamedTuple):
    robot: ref[Any]
    close: Callable[[], object]
    """Closes the robot if the program has no reference to it any more."""
    thread: int


_OPEN: list[_OpenRobot] = []

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_OPEN.clear)  # the robots belong to the process that opened them


def register(robot: object, close: Callable[[], object]) -> None:
    """Add an open robot.

    robot: the robot. Its method ``close`` closes it.
    close: a function that closes the robot if the program has no reference to it any more. It holds none itself.
    """
    _OPEN.append(_OpenRobot(ref(robot), close, get_ident()))


def unregister(robot: object) -> None:
    """Remove a robot that is closed."""
    _OPEN[:] = [each for each in _OPEN if each.robot() is not robot]


def close_lost() -> None:
    """Close the robots of this thread to which the program has no reference any more.

    A notebook loses a robot if a cell with ``robot = robotcore.open(...)`` runs twice.
    """
    if _OPEN:
        gc.collect()
    for each in [each for each in _OPEN if each.robot() is None and each.thread == get_ident()]:
        _OPEN.remove(each)
        each.close()


@atexit.register
def _close_all() -> None:
    while _OPEN:
        last = _OPEN.pop()
        robot = last.robot()
        (robot or last).close()
