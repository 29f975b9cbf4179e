"""The time limits of a run's parts for the watchdog, with the error for each."""

from __future__ import annotations

import sys
from pathlib import Path
from types import FrameType

from robotcore.errors import BackendError, RobotcoreError, WatchdogError
from robotcore.runtime.behaviour import Behaviour
from robotcore.safety import TimeLimit

GRACE_S = 1.0
OPENING_S = 60.0
"""A simulator may have a large scene to load, and a window to open."""

CLOSING_S = 10.0
"""A camera or a simulator may take its time to end."""

SIMULATION_FACTOR = 10.0
"""So much longer may those who look on take where all time is simulated: it waits for a disk, and nothing real moves.
The same goes for a simulator's window, which somebody may drag."""


def open_limit(backend: str) -> TimeLimit:
    """Return the stay in the opening of a robot."""

    def overdue(seconds: float, _frame: FrameType | None) -> BackendError:
        return BackendError(
            f"the backend {backend!r} has not opened the robot for {seconds:.0f} s. Does what it connects to answer?"
        )

    return TimeLimit(OPENING_S, overdue, GRACE_S)


def step_limit(app: Behaviour, limit_s: float) -> TimeLimit:
    """Return the stay in an app's step."""

    def overdue(seconds: float, frame: FrameType | None) -> WatchdogError:
        kind = type(app)
        return WatchdogError(
            f"{kind.__name__} has not come back from step for {seconds:.1f} s, in {app.state!r}{_line(kind, frame)}. "
            "An app never waits: return Status.RUNNING, and go on in the next tick"
        )

    return TimeLimit(limit_s, overdue, GRACE_S)


def observer_limit(limit_s: float) -> TimeLimit:
    """Return the stay with the observers."""

    def overdue(seconds: float, frame: FrameType | None) -> WatchdogError:
        return WatchdogError(f"what looks at the run has not come back for {seconds:.1f} s: {_innermost(frame)}")

    return TimeLimit(limit_s, overdue, GRACE_S)


def judge_limit(judge: Behaviour, backend: str) -> TimeLimit:
    """Return the stay with who judges the end of a run, and with the simulator that tells him the truth."""

    def overdue(seconds: float, frame: FrameType | None) -> RobotcoreError:
        kind = type(judge)
        if line := _line(kind, frame):
            return WatchdogError(f"{kind.__name__} has not come back from verify for {seconds:.1f} s{line}")
        return BackendError(f"the backend {backend!r} has not told the truth about the run's end for {seconds:.1f} s")

    return TimeLimit(CLOSING_S, overdue, 0.0)


def close_limit(backend: str) -> TimeLimit:
    """Return the stay at the end of a run, which nothing calls back: the process ends."""

    def overdue(seconds: float, _frame: FrameType | None) -> BackendError:
        return BackendError(f"the backend {backend!r} has not let go of the robot for {seconds:.1f} s")

    return TimeLimit(CLOSING_S, overdue, 0.0)


def _line(kind: type, frame: FrameType | None) -> str:
    """Return the line of the app's own file that a thread is at, in words; empty where it is at none."""
    file = getattr(sys.modules.get(kind.__module__), "__file__", None)
    while frame and frame.f_code.co_filename != file:
        frame = frame.f_back
    return f", at {_innermost(frame)}" if frame else ""


def _innermost(frame: FrameType | None) -> str:
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}" if frame else "it is nowhere to be seen"
