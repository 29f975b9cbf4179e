"""A robot whose calls let time pass, for a prompt, a notebook or a script."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from functools import partial
from threading import get_ident
from types import TracebackType
from typing import TYPE_CHECKING, Any, NoReturn

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.pending_routine import name_routine
from robotcore.autonomy.routines import Routine, take_generators, wait, wait_until, with_timeout
from robotcore.errors import BehaviourError, DeviceClosedError, Interrupted, RobotcoreError, UsageError
from robotcore.hal.robot import Robot, Role
from robotcore.hal.truth import Truth
from robotcore.interactive import open_robots
from robotcore.interactive.attribute_errors import raise_attribute_error
from robotcore.interactive.live_app import LiveApp
from robotcore.interactive.live_drive import LiveDrive
from robotcore.runtime.behaviour import Behaviour, Status, require_declarations
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import require_turn_on_spot
from robotcore.runtime.observer import RunContext
from robotcore.runtime.pace import PaceControl
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import RunSession
from robotcore.runtime.signals import SignalGuard, raise_again
from robotcore.view.robot_picture import RobotPicture, draw_robot

__all__ = ["LiveRobot"]

FinishResult = Callable[[RunResult], RunResult]
"""Adds the result of the recording to that of the session. Raises the error of a recording that failed."""


class LiveRobot(Robot):
    """An open robot for a prompt or a notebook. `robotcore.open` returns it.

    A call that drives or waits lets time pass, and returns when it is done. Between two calls the wheels stand, and a
    simulation stands still. A sensor then returns its newest sample. Ctrl-C stops the wheels and ends the call, and
    the robot stays open. After an error of the safety stage, the robot must be opened again.

    `close`, the end of a ``with`` block and the end of the program stop the motors and close the robot.

    session, loop, run, signals, finish: the parts of the run that `robotcore.open` has begun.

    >>> import robotcore
    >>> with robotcore.open("rover", world="open") as robot:
    ...     robot.wait(1.0)  # seconds
    ...     robot.clock.now()
    ...     robot.range.read()
    ...     pose = robot.drive.straight(0.5)  # metres
    ...     pose = robot.run(robotcore.turn(robot, 1.5))  # a routine
    ...     robot.ground_truth.contacts
    1.0
    Range nothing in range at 1.00 s
    0
    >>> robot.result.outcome.value
    'success'
    """

    def __init__(
        self, session: RunSession, loop: Loop, run: RunContext, signals: SignalGuard, finish: FinishResult
    ) -> None:
        opened = loop.robot
        drive = None
        if opened.has(Role.DRIVE):
            drive = LiveDrive(opened.drive, self, self.run, lambda: self.is_running)
        super().__init__(opened.name, opened.clock, opened.devices.values(), drive=drive, value_log=opened.value_log)
        del self.truth  # a backend's robot has it; a live robot has `ground_truth`
        assert isinstance(run.behaviour, LiveApp)
        self._app, self._run, self._signals, self._finish = run.behaviour, run, signals, finish
        self._loop: Loop | None = loop
        self._session, self._thread, self._process = session, get_ident(), os.getpid()
        self._reported: BaseException | None = None
        self.is_running = False
        """Whether a routine runs, so that time passes."""
        self.result: RunResult | None = None
        """The result of the session. None while the robot is open."""
        open_robots.register(self, partial(_close_session, session, loop, signals, finish))

    if not TYPE_CHECKING:  # a type checker finds unknown attributes itself

        def __getattr__(self, name: str) -> NoReturn:
            raise_attribute_error(name, {"robot": self, "robot.drive": vars(self).get("_drive")})

    @property
    def drive(self) -> LiveDrive:
        """The drive. Raises UnmetNeedError if no drive is open."""
        drive: LiveDrive = super().drive  # type: ignore[assignment]
        return drive

    @property
    def ground_truth(self) -> Truth | None:
        """The true state of the simulator. None on a real robot."""
        return self._run.truth

    @property
    def map(self) -> OccupancyGrid | None:
        """The map of the first range sensor, with poses by the odometry. None without a drive or such a sensor."""
        return self._app.grid

    @property
    def pace(self) -> PaceControl:
        """The pace of simulated time. Another thread may pause a call, or let single ticks of it run.

        Raises UsageError if the robot's time passes by itself, as that of a real robot.

        >>> import robotcore
        >>> with robotcore.open("rover", world="open", realtime=True) as robot:
        ...     robot.pace.speed = 10.0  # ten times as fast as real time
        ...     robot.wait(1.0)
        """
        if self._run.pace is None:
            text = f"the time of {self.name} passes by itself, so it has no pace. Use a simulator such as kinematic"
            raise UsageError(text, kind="no-pace")
        return self._run.pace

    def require_running(self) -> None:
        """Raise the error that has stopped the robot, such as an e-stop while the program waited for a person."""
        if self._loop and (error := self._loop.latched_error):
            self._reported = error
            raise error

    def run(self, routine: Routine[Any] | Behaviour) -> Any:
        """Run a routine or an app to its end, and return its result. The wheels stand afterwards.

        routine: a generator, such as ``straight(robot, 0.5)``, or an app, such as ``GreenSearch()``.

        Raises the exception of the routine, and the errors that end a run: SafetyStop, DeviceError and BackendError.
        """
        if isinstance(routine, type):
            raise UsageError(
                f"run needs an instance of the app. Write run({routine.__name__}())", kind="not-an-instance"
            )
        loop = self._require_ready()
        if isinstance(routine, Behaviour):
            require_declarations(routine)
            if routine.turns_on_spot:
                require_turn_on_spot(self._run.description)
            self._app.begin(_run_app(routine, self), type(routine).__name__)
        else:
            (generator,) = take_generators("run", [routine])
            self._app.begin(generator, name_routine(generator))
        try:
            with self._signals.defer(), self._signals:
                self._run_loop(loop)
        except Interrupted as interrupt:
            if interrupt.signal_number != signal.SIGINT:
                self._end(interrupt)
            self._signals.reset()
            raise_again(interrupt.signal_number)
        except RobotcoreError as error:
            self._reported = error
            cause = error.__cause__ if isinstance(error, BehaviourError) else None
            if cause is None:
                raise error.with_traceback(None) from None
            raise cause.with_traceback(_skip_own_frames(cause.__traceback__)) from cause.__cause__
        return self._app.result

    def wait(self, seconds: float) -> None:
        """Let a time in seconds pass. The wheels stand."""
        self.run(wait(self, seconds))

    def wait_until(self, condition: Callable[[], object], *, timeout_s: float | None = None) -> None:
        """Let time pass until ``condition()`` is true. It is called once per tick.

        timeout_s: the longest time in seconds; None for no limit.

        Raises RoutineTimeoutError, a TimeoutError, if the time is over.
        """
        routine = wait_until(condition)
        self.run(routine if timeout_s is None else with_timeout(self, timeout_s, routine))

    def show(self) -> RobotPicture:
        """Return a picture of the robot: its camera, the world from above, and its last readings.

        A notebook shows the picture. ``robot.show().save("robot.png")`` writes it. A real robot is drawn on its map.
        """
        self._require_ready()
        if self.has(Role.CAMERA):
            self.camera.read()
        world = self._run.world if self._run.truth else None
        return draw_robot(self, self._run.description, self._app.path, world=world, grid=None if world else self.map)

    def close(self) -> None:
        """Stop the motors, and close the robot and its recording. A second call does nothing.

        Raises an error of the session that no call has raised yet.
        """
        self._end(Outcome.SUCCESS)

    def __enter__(self) -> LiveRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._end(Outcome.FAILURE if error else Outcome.SUCCESS)

    def _run_loop(self, loop: Loop) -> None:
        self.is_running = True
        try:
            loop.resume()
            loop.run()
        finally:
            self.is_running = False
            loop.pause()

    def _end(self, outcome: Outcome | BaseException) -> None:
        if self._loop is None or os.getpid() != self._process:  # the robot belongs to the process that opened it
            return
        self._require_thread()
        if self.is_running:
            raise UsageError("a routine cannot close its robot. End the routine first", kind="closed-in-routine")
        self._signals.mask()
        with self._signals:
            loop, self._loop = self._loop, None
            open_robots.unregister(self)
            self.result = self._session.close(loop.latched_error or outcome)
            error = self.result.error
            if error and error is not self._reported and error is not outcome:
                raise error
            self.result = self._finish(self.result)
        if number := self._signals.last:
            raise_again(number)

    def _require_ready(self) -> Loop:
        if self._loop is None:
            raise DeviceClosedError(self.name)
        if os.getpid() != self._process:
            text = f"{self.name} was opened in another process. Make all calls in the process that opened it"
            raise UsageError(text, kind="wrong-process")
        if self.is_running:
            text = "a call that lets time pass was made within a routine. Write yield from, as in"
            raise UsageError(f"{text} yield from straight(robot, 0.5)", kind="call-in-routine")
        self._require_thread()
        if (error := self._loop.latched_error) and error is self._reported:
            text = f"{self.name} was stopped by an error. Close it, and open it again. The error: {error}"
            raise UsageError(text, kind="robot-stopped")
        return self._loop

    def _require_thread(self) -> None:
        if get_ident() != self._thread:
            text = f"{self.name} was opened in another thread. Make all calls in the thread that opened it"
            raise UsageError(text, kind="wrong-thread")

    def __repr__(self) -> str:
        if self._loop and not self._loop.latched_error:
            return super().__repr__()
        return f"<Robot {self.name}: {'stopped by an error' if self._loop else 'closed'}>"


def _run_app(app: Behaviour, robot: Robot) -> Routine[Status]:
    """Run an app with the checks of a run: each of its ticks is a call of ``step``."""
    try:
        return (yield from Behaviour.run(app, robot))
    finally:
        app.close_routine()


def _close_session(session: RunSession, loop: Loop, signals: SignalGuard, finish: FinishResult) -> None:
    if session.result is None:
        signals.mask()
        with signals:
            finish(session.close(loop.latched_error or Outcome.SUCCESS))
        if number := signals.last:
            raise_again(number)


def _skip_own_frames(traceback: TracebackType | None) -> TracebackType | None:
    """Return the part of a traceback that begins in the user's code."""
    while traceback and traceback.tb_frame.f_globals.get("__name__", "").startswith("robotcore."):
        traceback = traceback.tb_next
    return traceback
