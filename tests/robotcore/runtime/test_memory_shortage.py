"""Runs whose memory has run out: the error that ended the loop is the error of the run.

`tests.robotcore.safety.guardian.test_exhausted_run` uses up the memory of real processes.
"""

from __future__ import annotations

from contextlib import suppress
from inspect import GEN_SUSPENDED, getgeneratorstate
from typing import Any

import pytest

from robotcore import Routine
from robotcore.autonomy.routines import on_stop
from robotcore.errors import BehaviourError, EmergencyStopError, InvalidCommandError, ResourceError
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.loop import Loop
from robotcore.runtime.session import RunSession
from robotcore.safety.thread_reserve import Reserve
from tests.robotcore.runs import Runner, Watcher, drive_then, drive_then_raise, drive_wheels


class BareMemoryError(MemoryError):
    """Has no context, because Python makes such an error before the memory has run out."""

    __context__ = property(lambda self: None, lambda self, context: None)


@pytest.fixture
def _shortage(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the memory run out after the motors have been stopped."""

    def run_out(*_: object) -> None:
        raise BareMemoryError

    monkeypatch.setattr(RunSession, "_judge", run_out)


def command_nan(robot: Robot) -> None:
    drive_wheels(robot, float("nan"))


@pytest.mark.usefixtures("_shortage")
@pytest.mark.parametrize(
    "app, error",
    [
        (drive_then(command_nan), InvalidCommandError),
        (drive_then_raise(ValueError("broken")), BehaviourError),
        (drive_then(lambda _: Status.SUCCESS), ResourceError),
    ],
    ids=["safety", "app", "none"],
)
def test_error_of_the_loop_is_kept(perform: Runner, app: Behaviour, error: type[Exception]) -> None:
    assert type(perform(app).error) is error


def test_error_of_the_latch_is_kept_if_the_loop_has_no_memory_to_raise_it(
    perform: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Loop.run

    def run_out(loop: Loop) -> Any:
        with suppress(InvalidCommandError):
            return run(loop)
        raise BareMemoryError

    monkeypatch.setattr(Loop, "run", run_out)
    assert type(perform(drive_then(command_nan)).error) is InvalidCommandError


class Driving(Behaviour):
    """Drives on, and records its clean-up."""

    def __init__(self, events: list[str]) -> None:
        self._events = events

    def run(self, robot: Robot) -> Routine[Status]:
        yield from on_stop(self._drive(robot), lambda: self._events.append("clean-up"))
        return Status.SUCCESS

    def _drive(self, robot: Robot) -> Routine[None]:
        while True:
            yield


class Press(Watcher):
    """Presses the emergency stop after the third tick, so that the error comes from outside of the app."""

    def tick(self, record: Any) -> None:
        super().tick(record)
        if record.tick == 3:
            self.calls[0][1].emergency.press("the button was pressed")


def test_reserved_memory_is_free_before_the_clean_up_of_a_stopped_app(
    perform: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    events: list[str] = []
    monkeypatch.setattr(Reserve, "release_memory", lambda self: events.append("release"))
    result = perform(Driving(events), observers=[Press()])
    assert isinstance(result.error, EmergencyStopError)
    assert events[:2] == ["release", "clean-up"]


def test_reserved_memory_is_free_before_an_exception_passes_through_the_stages(
    perform: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    sessions: list[RunSession] = []
    states: list[str] = []
    close = RunSession.close

    def begin_close(session: RunSession, *arguments: Any) -> Any:
        sessions.append(session)
        return close(session, *arguments)

    def record(_: Reserve) -> None:
        states.extend(getgeneratorstate(session._stages) for session in sessions)

    monkeypatch.setattr(RunSession, "close", begin_close)
    monkeypatch.setattr(Reserve, "release_memory", record)
    assert perform(drive_then_raise(ValueError("broken"))).outcome.value == "error"
    assert states[0] == GEN_SUSPENDED
