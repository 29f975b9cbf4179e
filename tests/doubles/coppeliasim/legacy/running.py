"""Answers about the run itself: start, pause and stop, step by step, and the errors so far."""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable

from tests.doubles.coppeliasim.legacy.codec import Command
from tests.doubles.coppeliasim.legacy.codes import Code
from tests.doubles.coppeliasim.legacy.objects import INT, handle
from tests.doubles.coppeliasim.legacy.refused import Answers, RefusedError
from tests.doubles.coppeliasim.scene.simulator import Simulator

Errors = deque[str]
ERRORS_KEPT = 50


def answers_on_the_run(running: Running) -> Answers:
    """Return what a client can ask about the run."""
    return {
        Code.START_PAUSE_STOP_SIMULATION: running.start_pause_stop,
        Code.SYNCHRONOUS_ENABLE: running.hold_time,
        Code.SYNCHRONOUS_DISABLE: running.let_time_pass,
        Code.SYNCHRONOUS_NEXT: running.trigger,
        Code.GET_LAST_ERRORS: running.last_errors,
    }


class Running:
    """The commands that name nothing; ``client`` is who steps, ``errors`` are those of its own calls."""

    def __init__(self, simulator: Simulator, client: Hashable, errors: Errors) -> None:
        self._simulator, self._client, self._errors = simulator, client, errors
        self._is_triggered = False

    def start_pause_stop(self, command: Command) -> bytes:
        number = handle(command)
        if not 0 <= number <= 2:
            raise RefusedError
        (self._simulator.start, self._simulator.pause, self._simulator.stop)[number]()
        return b""

    def hold_time(self, command: Command) -> bytes:
        """Let no time pass but by triggers, until told otherwise or until the simulation stops."""
        if not self._steps:
            self._simulator.stepping.raise_level(self._client)
        return b""

    def let_time_pass(self, command: Command) -> bytes:
        self.leave()
        return b""

    def leave(self) -> None:
        """Hold time no longer."""
        self._simulator.stepping.forget(self._client)
        self._simulator.changed.notify_all()

    def trigger(self, command: Command) -> bytes:
        """Ask for a time step, which comes after the other commands; an error where time is not held, or stands."""
        if not self._steps or not self._simulator.state.is_advancing:
            raise RefusedError
        self._is_triggered = True
        return b""

    def step(self) -> None:
        """Take the step that was asked for."""
        if self._is_triggered:
            self._is_triggered = False
            self._simulator.step(self._client)

    def last_errors(self, command: Command) -> bytes:
        """Return how many there are and their texts, each with its zero, and forget them."""
        texts = b"".join(error.encode() + b"\0" for error in self._errors)
        answer = INT.pack(len(self._errors)) + texts
        self._errors.clear()
        return answer

    @property
    def _steps(self) -> bool:
        return bool(self._simulator.stepping.level(self._client))
