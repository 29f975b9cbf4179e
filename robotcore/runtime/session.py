"""Runs an app: opens the robot, runs the loop, stops the motors, verifies the run, and closes the robot."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from typing import TypeVar

from robotcore.errors import (
    BackendError,
    DeviceClosedError,
    DeviceError,
    DeviceGroupError,
    Interrupted,
    ResourceError,
    RobotcoreError,
)
from robotcore.hal.backend import Capability
from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.active_runs import register_run
from robotcore.runtime.forced_exit import SHUTDOWN_GRACE_S, ForcedExit, print_reason
from robotcore.runtime.hand_driving import HandDriving
from robotcore.runtime.layers import AssembledRobot, assemble
from robotcore.runtime.layers.base import Tap
from robotcore.runtime.layers.guardian import guard_motors
from robotcore.runtime.layers.timing import TickTimer
from robotcore.runtime.loop import Loop
from robotcore.runtime.observer import Observer, RunContext, notify_end
from robotcore.runtime.operator_input import OPERATOR, OperatorInput, open_operator
from robotcore.runtime.pace import PaceControl
from robotcore.runtime.plan import Plan, RunRequest
from robotcore.runtime.result import Outcome, RealTimeNote, RunResult, WrittenNote, get_outcome
from robotcore.runtime.result_building import build_result
from robotcore.runtime.signals import SignalGuard, WatchdogInterrupt
from robotcore.runtime.success_verification import Verification, verify_run
from robotcore.runtime.tick_statistics import TickStatistics
from robotcore.runtime.time_limits import (
    SIMULATION_FACTOR,
    build_open_limit,
    build_step_limit,
    close_limit,
    judge_limit,
    observer_limit,
)
from robotcore.runtime.trace import TickRecord
from robotcore.runtime.wait_monitor import WaitMonitor
from robotcore.safety.latch import EmergencyStop
from robotcore.safety.motor_stop import STOP_S
from robotcore.safety.real_time import HANG_S, RealTimeTicks
from robotcore.safety.thread_reserve import Reserve
from robotcore.safety.watchdog import ActivityMonitor, Watchdog
from robotcore.threads import has_threads

__all__ = ["Observer", "RunContext", "RunRequest", "RunResult", "run"]

WAKE_UP_S = 0.3
"""The wait for new samples after a suspension of the program, in seconds."""

SHUTDOWN_THREADS = 9
"""The number of reserved threads for the calls that may hang on a forced exit.

The calls are the latch, the closing of the robot, the observers and ``on_forced_exit``. Others write two notes of the
watchdog, one about steps that wait, one of an observer, and the lines of all threads.
"""

NO_WATCHDOG = "this Python has no threads, and so no watchdog. If the app or the simulator hangs, the run does not end"
"""The note of a run without threads."""


T = TypeVar("T")

_Stages = Generator[Loop, Outcome, T]
"""A run that yields its loop when the robot is open, and continues with the outcome of the loop."""


class _CloseTimeoutError(Exception):
    pass


class RunSession:
    """Executes one run.

    plan: the plan of the run.
    observers, taps, on_forced_exit, timeout_scale: the parameters of `run`.
    signals: the signal guard. The caller must have entered its context.
    """

    def __init__(
        self,
        plan: Plan,
        observers: Sequence[Observer],
        taps: Sequence[Tap],
        signals: SignalGuard,
        on_forced_exit: Callable[[RunResult], object],
        timeout_scale: float,
    ) -> None:
        self._plan, self._observers, self._taps, self._signals = plan, observers, taps, signals
        self._notes = list(plan.notes)
        self._wall, self._activity = MonotonicClock(), ActivityMonitor()
        timeout_scale *= SIMULATION_FACTOR if plan.request.gui else 1.0
        self._reserve = Reserve(self._wall)
        self._forced_exit = ForcedExit(self._reserve, observers, on_forced_exit)
        self._watchdog = Watchdog(
            self._activity,
            self._on_timeout,
            self._end_after_hang,
            self._reserve,
            timeout_scale,
            self._add_note,
            HANG_S,
            self._drop_real_time,
        )
        self._close_limit = close_limit(plan.backend.name)
        self._has_threads = has_threads() or Capability.LOCKSTEP not in plan.backend.capabilities
        """Whether the run needs threads. Only a simulation in lockstep runs without them, since nothing real moves."""

        self._timeout_error: RobotcoreError | None = None
        self._assembled: AssembledRobot | None = None
        self._truth: Truth | None = None
        self._operator: OperatorInput | None = None
        self._real_time: RealTimeTicks | None = None
        self._guardian = ExitStack()
        self._loop: Loop | None = None
        self._statistics = TickStatistics()
        self._verification = Verification()
        self._late_failure: RobotcoreError | None = None
        self._is_hung = False
        """Whether a call of the backend or of a device hangs."""

        self._stages = self._run_to_end()
        self._loop_end: Outcome | BaseException | None = None
        self.result: RunResult | None = None
        """The result. None until the run has ended."""

    def run(self) -> RunResult:
        """Execute the run, notify the observers of its end, and return the result."""
        try:
            if loop := self.open():
                try:
                    outcome = loop.run()
                except BaseException as error:  # noqa: BLE001  `close` returns or raises it
                    return self.close(error)
                return self.close(outcome)
            assert self.result
            return self.result
        finally:  # a signal may have come outside of the stages
            self._stages.close()

    def open(self) -> Loop | None:
        """Open the robot, and call the observers' ``begin``. Return the loop; None if this failed, and the run ended.

        The caller runs the loop, and then calls `close` with its outcome or exception.
        """
        return self._continue(partial(next, self._stages))

    def close(self, end: Outcome | BaseException) -> RunResult:
        """Stop the motors, close the robot, call the observers' ``end``, and return the result.

        end: the outcome of the loop, or the exception that ended it.

        Raises the exception if it is neither an error of robotcore nor a signal.
        """
        self._reserve.release_memory()  # the stages need memory for an exception that passes through them
        latched = self._loop and self._loop.latched_error  # `_stop` sets the latch too
        self._loop_end = latched or end
        throw, send = self._stages.throw, self._stages.send
        self._continue(partial(throw, end) if isinstance(end, BaseException) else partial(send, end))
        assert self.result
        return self.result

    def _continue(self, enter: Callable[[], Loop]) -> Loop | None:
        try:
            return enter()
        except StopIteration as end:
            self.result = end.value
            return None

    def _run_to_end(self) -> _Stages[RunResult]:
        try:
            return (yield from self._run_and_notify())
        finally:
            with suppress(MemoryError):
                self._reserve.close()

    def _run_and_notify(self) -> _Stages[RunResult]:
        error: RobotcoreError | Interrupted | None = None
        try:
            outcome = yield from self._run_under_watchdog()
        except (RobotcoreError, Interrupted) as caught:
            error, outcome = caught, get_outcome(caught)
        except MemoryError as short:
            error = _find_cause(short) or self._loop_error or ResourceError("the program is out of memory")
            outcome = get_outcome(error)
        except WatchdogInterrupt:  # the loop had ended, so it could not raise the latch's error
            error = self._latched_error
            outcome = get_outcome(error)
        except BaseException as bug:
            result = self._build_result(RobotcoreError(f"{type(bug).__name__}: {bug}"), Outcome.ERROR)
            notify_end(self._observers, result)
            raise
        if self._late_failure and error is None:
            error, outcome = self._late_failure, Outcome.ERROR
        result = self._build_result(error, outcome)
        if failures := notify_end(self._observers, result):
            raise failures[0]
        return result

    def _run_under_watchdog(self) -> _Stages[Outcome]:
        if self._has_threads:
            self._reserve.hold(SHUTDOWN_THREADS)
            self._watchdog.start()
        else:
            self._reserve.hold(threads=0)
            self._notes.append(NO_WATCHDOG)
        try:
            return (yield from self._run_and_close())
        finally:
            self._watchdog.close()

    def _run_and_close(self) -> _Stages[Outcome]:
        plan = self._plan
        self._activity.begin(build_open_limit(plan.backend.name))
        raw = robot = plan.backend.open(plan.setup)
        self._activity.begin(None)
        self._notes += raw.notes
        outcome = Outcome.ERROR
        try:
            self._truth = self._build_truth(raw)
            if plan.request.has_operator and OPERATOR.name not in raw.devices:  # a replay has its recorded operator
                self._operator = open_operator(raw, plan.description)
            self._assembled = assembled = self._assemble(raw)
            robot = assembled.robot
            if assembled.polling:
                assembled.polling.begin()
            outcome = yield self._begin(assembled, self._truth)
        finally:
            self._reserve.release_memory()
            try:
                self._signals.mask()
                self._stop(raw)
                self._judge(outcome)
            finally:  # a signal may have come just before the mask
                self._signals.mask()
                try:
                    if self._real_time:
                        self._real_time.end()
                finally:
                    self._close(robot)
        return outcome

    def _begin(self, assembled: AssembledRobot, truth: Truth | None) -> Loop:
        """Build the loop, and call the observers' ``begin``."""
        plan, safety = self._plan, self._plan.description.safety
        stop, is_simulated = EmergencyStop(assembled.latch), assembled.robot.clock.is_lockstep
        pace = PaceControl(1.0 if plan.request.realtime or plan.request.gui else math.inf) if is_simulated else None
        self._loop = Loop(
            assembled,
            plan.behaviour,
            plan.request.rate_hz,
            plan.request.timeout_s,
            [*self._list_listeners(truth)],
            build_step_limit(plan.behaviour, safety.watchdog_s),
            observer_limit(safety.watchdog_s * (SIMULATION_FACTOR if is_simulated else 1.0)),
            safety.outage_s,
            WaitMonitor(self._add_note) if is_simulated else None,
            HandDriving(assembled.robot, plan.description) if plan.request.has_operator else None,
            pace,
            self._signals.check,
        )
        self._signals.last_resort = self._stop_after_signals
        self._signals.before_suspension = partial(assembled.suspend, "suspension")
        self._signals.after_suspension = self._wait_for_sensors
        self._signals.is_suspension_deferred = True
        run = RunContext(
            plan.request,
            plan.behaviour,
            plan.description,
            plan.world,
            assembled.robot,
            truth,
            stop,
            plan.faults,
            self._operator,
            self._statistics,
            pace,
            partial(getattr, self._loop, "overruns"),
            self._add_note,
        )
        with self._signals.defer():
            for observer in self._observers:
                observer.begin(run)
        return self._loop

    def _list_listeners(self, truth: Truth | None) -> Iterator[Callable[[TickRecord], None]]:
        if self._real_time:
            yield self._real_time.begin_after_first_tick
        if truth and truth.line:
            yield lambda _: truth.update()
        yield from (observer.tick for observer in self._observers)

    def _wait_for_sensors(self) -> None:
        # After a suspension of the program, the last samples are too old.
        self._wall.sleep_until(self._wall.now() + WAKE_UP_S)

    def _assemble(self, raw: Robot) -> AssembledRobot:
        plan = self._plan
        seed, rate_hz = plan.setup.seed, plan.request.rate_hz
        faults = [fault.layer(raw.clock, seed) for fault in plan.faults]
        if raw.cutoffs:
            self._register(plan.request)
        if plan.request.has_real_time_priority:
            add_note = partial(self._add_note, kind=RealTimeNote)
            self._real_time = RealTimeTicks(add_note, has_guardian=bool(raw.cutoffs))
        priorities = self._real_time.priorities if self._real_time else None
        lease = plan.description.safety.lease_ticks / rate_hz
        guard = guard_motors(raw, lease, self._guardian, priorities.stop if priorities else None)
        assembled = assemble(
            raw,
            plan.description,
            rate_hz,
            plan.conditions,
            seed,
            faults,
            self._taps,
            guard,
            self._activity,
            self._reserve,
            TickTimer(self._statistics),
            plan.backend.encoder_rate_hz,
        )
        self._reserve.hold(len(raw.motors) if self._has_threads else 0)
        raw.clock.prepare_calls()
        return assembled

    def _register(self, request: RunRequest) -> None:
        try:
            self._guardian.enter_context(register_run(request.backend, request.robot, request.options))
        except OSError as error:
            self._notes.append(f"robotcore stop needs --backend and --robot to stop the robot of this run: {error}")

    def _build_truth(self, raw: Robot) -> Truth | None:
        if raw.truth is None or self._plan.world is None:
            return None
        return Truth(raw.truth, self._plan.description, self._plan.world)

    def _stop(self, raw: Robot) -> None:
        """Trip the latch and stop the motors, so that no thread of the app can move them.

        A stop that fails is not reported, because closing the robot repeats it. A stop that hangs is reported. In a
        lockstep simulation a stop may take longer, because no time passes in the simulation.
        """
        if assembled := self._assembled:
            self._activity.begin(self._close_limit)
            assembled.latch.set(DeviceClosedError(raw.name))
            may_be_slow = raw.clock.is_lockstep and not self._is_hung
            failures = assembled.motor_stops.apply_apart(
                self._plan.description.safety.answer_s if may_be_slow else STOP_S
            )
            if assembled.motor_stops.are_hung and not self._is_hung:
                late = [each for each in failures if isinstance(each, DeviceError)]
                if late:
                    self._late_failure = late[0] if len(late) == 1 else DeviceGroupError(f"stopping {raw.name}", late)

    def _judge(self, outcome: Outcome) -> None:
        if not self._is_hung:
            plan = self._plan
            self._activity.begin(judge_limit(plan.judge, plan.backend.name))
            self._verification = verify_run(plan.judge, self._truth, outcome, plan.request.judge)
            self._late_failure = self._late_failure or self._verification.failure

    def _close(self, robot: Robot) -> None:
        # The guardian's context ends with _CloseTimeoutError if closing the robot hangs, so it stops the motors.
        self._activity.begin(self._close_limit)
        try:
            with suppress(_CloseTimeoutError), self._guardian:
                if self._assembled and self._assembled.polling:
                    self._assembled.polling.end()
                if self._is_hung or (self._assembled and self._assembled.motor_stops.are_hung):
                    closing = self._reserve.call(robot.close)
                    if not closing.is_done_within(SHUTDOWN_GRACE_S) or closing.failure:
                        raise _CloseTimeoutError
                else:
                    robot.close()
        except RobotcoreError as failure:
            self._late_failure = failure

    @property
    def _loop_error(self) -> RobotcoreError | Interrupted | None:
        """The error that ended the loop. None if there was none, or another exception."""
        return self._loop_end if isinstance(self._loop_end, (RobotcoreError, Interrupted)) else None

    @property
    def _latched_error(self) -> RobotcoreError:
        error = (self._assembled and self._assembled.latch.error) or self._timeout_error
        assert error
        return error

    def _on_timeout(self, error: RobotcoreError) -> None:
        self._timeout_error = error
        self._is_hung = isinstance(error, (BackendError, DeviceError))
        try:
            if self._assembled:
                self._assembled.latch.set(error)
        finally:
            self._signals.interrupt_main_thread()

    def _add_note(self, note: str, kind: type[WrittenNote] = WrittenNote) -> None:
        self._notes.append(kind(note))
        self._forced_exit.write(f"note: {note}\n".encode())

    def _drop_real_time(self) -> None:
        if self._real_time:
            self._real_time.drop_priority_of_run()

    def _end_after_hang(self, error: RobotcoreError) -> None:
        """End the process after the watchdog has stopped the motors, because the run's thread still hangs."""
        try:
            self._reserve.release_memory()
            self._forced_exit.write_stacks()  # before the result, which is the last text in a terminal
            # The result includes the interventions that no tick recorded.
            result = self._build_result(error, get_outcome(error))
            unreported = self._loop.unreported_interventions if self._loop else ()
            seconds = {**{each.cause: 0.0 for each in unreported}, **result.intervention_s}
            self._forced_exit.report(
                replace(result, interventions=result.interventions + len(unreported), intervention_s=seconds)
            )
        finally:
            os._exit(error.exit_status)

    def _stop_after_signals(self) -> None:
        """Stop every motor and report the result. `SignalGuard` then ends the process.

        Another thread trips the latch, because the last signal may have interrupted this thread in a call that hangs.
        """
        assert self._assembled
        self._reserve.release_memory()
        try:
            trip = partial(self._assembled.latch.set, DeviceClosedError(self._assembled.robot.name))
            self._reserve.call(trip).is_done_within(SHUTDOWN_GRACE_S)
        finally:
            try:
                self._assembled.motor_stops.apply_apart()
            finally:
                if raised := self._signals.raised:
                    self._forced_exit.report(self._build_result(raised, get_outcome(raised)))

    def _build_result(self, error: RobotcoreError | Interrupted | None, outcome: Outcome) -> RunResult:
        return build_result(
            self._plan,
            outcome,
            error,
            self._late_failure,
            self._verification,
            self._loop,
            self._statistics,
            self._notes,
            self._wall.now(),
        )


def _find_cause(error: BaseException) -> RobotcoreError | Interrupted | None:
    """Return the error that was handled when the program ran out of memory. None if there was none."""
    while context := error.__context__:
        if isinstance(context, (RobotcoreError, Interrupted)):
            return context
        error = context
    return None


def run(
    request: RunRequest,
    observers: Sequence[Observer] = (),
    taps: Sequence[Tap] = (),
    *,
    on_forced_exit: Callable[[RunResult], object] = print_reason,
    timeout_scale: float = 1.0,
) -> RunResult:
    """Run an app and return its result.

    request: the app, the backend, the robot and the world.
    observers: objects that get the description of the run, the record of each tick, and the result.
    taps: layers that get every sample that the app reads and every command that the app gives.
    on_forced_exit: a function that gets the result if an app or a driver hangs and cannot be interrupted.
    timeout_scale: a factor that multiplies every time limit of the run.

    Raises UsageError, DescriptionError, BehaviourError and BackendMissingError if the run cannot be planned. A later
    error, such as an unknown option of the backend or an exception of the app, stops every motor. It is in the result:
    ``error``, ``reason`` and ``exit_status``. Another thread calls ``on_forced_exit`` before the process ends.

    >>> from robotcore import RunRequest
    >>> result = run(RunRequest("green-search", seed=7))
    >>> result.outcome.value, result.verified
    ('success', True)
    >>> result.milestones
    {'search': 0.0, 'seen': 7.25, 'approach': 7.95, 'arrived': 21.4}
    """
    plan = Plan.resolve(request)
    with SignalGuard() as signals:
        return RunSession(plan, observers, taps, signals, on_forced_exit, timeout_scale).run()
