"""The watchdog's time limits for the activities of a run, with the error of each."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path
from types import FrameType

from robotcore.errors import BackendError, RobotcoreError, WatchdogError
from robotcore.runtime.behaviour import Behaviour, find_defined_method
from robotcore.safety.watchdog import TimeLimit

GRACE_S = 1.0
"""The time in seconds that an app or an observer has to return after the watchdog's interruption."""

OPENING_S = 60.0
"""The limit for opening a robot, in seconds. A simulator may load a large scene and open a window."""

CLOSING_S = 10.0
"""The limit for closing a robot, in seconds. A camera or a simulator may take long to end."""

SIMULATION_FACTOR = 10.0
"""The factor that multiplies the observers' time limit in a simulation. An observer may wait for a slow disk.

In a run with a window it multiplies every time limit, because a simulator stops while the user drags its window.
"""

_OWN = "robotcore."
"""The beginning of the names of robotcore's modules."""

_HANG_TEXTS = {
    "step": ("return", "Do not wait in step: return Status.RUNNING, and continue in the next tick"),
    "run": ("yield", "Do not wait in run: yield in each round of a loop, or write yield from wait(robot, seconds)"),
}
"""The verb and the remedy in the error of an app that hangs, by the method that the app defines."""


def build_open_limit(backend: str) -> TimeLimit:
    """Return the time limit for opening a robot."""
    advice = "Check that the simulator or board that it connects to answers"
    return TimeLimit(
        OPENING_S,
        lambda seconds, _: BackendError(
            f"the backend {backend!r} did not open the robot within {seconds:.0f} s. {advice}",
            kind="opening-timeout",
            seconds=seconds,
        ),
        GRACE_S,
    )


def build_step_limit(app: Behaviour, limit_s: float) -> TimeLimit:
    """Return the time limit for one tick of an app."""

    def build_error(seconds: float, frame: FrameType | None) -> WatchdogError:
        kind, state, method = type(app), str(app.state), find_defined_method(app)
        verb, remedy = _HANG_TEXTS[method]
        return WatchdogError(
            f"{kind.__name__}.{method} did not {verb} within {seconds:.1f} s, in state {state!r}{_line(kind, frame)}. "
            f"{remedy}",
            kind="step-timeout",
            seconds=seconds,
            state=state,
        )

    return TimeLimit(limit_s, build_error, GRACE_S, is_step=True)


def observer_limit(limit_s: float) -> TimeLimit:
    """Return the time limit for the observers in one tick."""
    return TimeLimit(
        limit_s,
        lambda seconds, frame: WatchdogError(
            f"an observer of the run did not return within {seconds:.1f} s: {_innermost(frame)}",
            kind="observer-timeout",
            seconds=seconds,
            line=_innermost(frame),
        ),
        GRACE_S,
    )


def judge_limit(judge: Behaviour, backend: str) -> TimeLimit:
    """Return the time limit for the judge's ``verify``, which also reads the true state of the simulator."""

    def build_error(seconds: float, frame: FrameType | None) -> RobotcoreError:
        if line := _line(type(judge), frame):
            text = f"{type(judge).__name__}.verify did not return within {seconds:.1f} s{line}"
            return WatchdogError(text, kind="verify-timeout")
        text = f"the backend {backend!r} did not return the simulator's truth within {seconds:.1f} s"
        return BackendError(text, kind="truth-timeout")

    return TimeLimit(CLOSING_S, build_error, 0.0)


def close_limit(backend: str) -> TimeLimit:
    """Return the time limit for closing a robot. A longer close ends the process."""
    text = f"the backend {backend!r} did not close the robot within"
    return TimeLimit(CLOSING_S, lambda seconds, _: BackendError(f"{text} {seconds:.1f} s", kind="closing-timeout"), 0.0)


def _line(kind: type, frame: FrameType | None) -> str:
    """Return the line that a thread executes in an app's file, such as ``, at app.py:42``. Empty if there is none.

    An app of robotcore, such as that of a live robot, calls a user's routine. The line is then that of the routine.
    """
    module, frames = kind.__module__, list(_list_frames(frame))
    if module.startswith(_OWN):
        called = takewhile(lambda each: _name_module(each) != module, frames)
        module = [module, *(name for each in called if not (name := _name_module(each)).startswith(_OWN))][-1]
    line = next((each for each in frames if _name_module(each) == module), None)
    return f", at {_innermost(line)}" if line else ""


def _list_frames(frame: FrameType | None) -> Iterator[FrameType]:
    while frame:
        yield frame
        frame = frame.f_back


def _name_module(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__"))


def _innermost(frame: FrameType | None) -> str:
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}" if frame else "its line is unknown"
