"""The calls of an app: its ``step``, the clean-up of its routine, and its texts. Other exceptions become errors."""

from __future__ import annotations

import os
import reprlib
from typing import Literal

from robotcore.errors import BehaviourError, Interrupted, RobotcoreError, UsageError
from robotcore.hal.clock import Clock
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Behaviour, Status, find_defined_method, require_callable, require_status
from robotcore.runtime.forks import end_fork
from robotcore.runtime.print_capture import PrintCapture
from robotcore.runtime.signals import WatchdogInterrupt
from robotcore.runtime.wait_monitor import WaitMonitor
from robotcore.safety.latch import Latch
from robotcore.safety.thread_reserve import Reserve


class AppCalls:
    """Calls an app on a robot, and copies the texts that it prints.

    latch: the first error of the run. It is raised in place of an exception of the app, because it is the cause.
    reserve: the memory that is released for an exception of the app.
    waits: the monitor of the app's steps in a simulation; None on a real robot.
    """

    def __init__(
        self,
        behaviour: Behaviour,
        robot: Robot,
        clock: Clock,
        latch: Latch,
        reserve: Reserve,
        waits: WaitMonitor | None,
    ) -> None:
        self._behaviour, self._robot, self._clock = behaviour, robot, clock
        self._latch, self._reserve, self._waits = latch, reserve, waits
        self._process = os.getpid()
        self.prints = PrintCapture()

    def decide(self) -> Status:
        """Call the app's ``step``, and return its status. Raises BehaviourError for an exception of the app."""
        app = type(self._behaviour)
        try:
            status = self._step()
        except UsageError as error:
            raise BehaviourError.from_exception(app, error) from error
        except (RobotcoreError, Interrupted, WatchdogInterrupt):
            raise
        except BaseException as error:
            self._reserve.release_memory()
            self._latch.check()
            require_callable(self._behaviour, find_defined_method(self._behaviour))
            raise BehaviourError.from_exception(app, error) from error
        return require_status(self._behaviour, status)

    def _step(self) -> object:
        if self._waits:
            self._waits.begin()
        try:
            with self.prints:
                status = self._behaviour.step(self._robot)
            if self._waits:
                self._waits.end(self._clock.now())
            return status
        finally:
            if os.getpid() != self._process:
                end_fork(f"{type(self._behaviour).__name__}.step")

    def close_routine(self) -> None:
        """Let the clean-up of the app's ``run`` command the robot. Raises BehaviourError if it fails."""
        try:
            with self.prints:
                self._behaviour.close_routine()
        except (RobotcoreError, Interrupted, WatchdogInterrupt):
            raise
        except BaseException as error:
            raise BehaviourError.from_exception(type(self._behaviour), error) from error

    def read_text(self, name: Literal["state", "reason"]) -> str:
        """Return the app's state or reason. Raises BehaviourError if it is not a text that UTF-8 can encode."""
        app = type(self._behaviour)
        try:
            text: object = getattr(self._behaviour, name)
        except Exception as error:  # an app may define state or reason as a property
            raise BehaviourError.from_exception(app, error) from error
        if not isinstance(text, str):
            raise BehaviourError(
                f"{app.__name__}.{name} is {reprlib.repr(text)}. Set it to a text", kind=f"{name}-not-a-text"
            )
        try:
            text.encode()
        except UnicodeEncodeError as error:
            raise BehaviourError(
                f"{app.__name__}.{name} is {reprlib.repr(text)}, which cannot be written as UTF-8. Replace its "
                'surrogates, for example with text.encode(errors="replace").decode()',
                kind=f"{name}-not-encodable",
            ) from error
        return text
