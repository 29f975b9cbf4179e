"""A run from opening to closing, with every way out of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial

from robotcore.errors import BackendError, DeviceClosedError, DeviceError, Interrupted, ResourceError, RobotcoreError
from robotcore.hal.clock import Clock
from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.hal.wall_clock import MonotonicClock, PacedClock
from robotcore.runtime.layers import Assembled, assemble
from robotcore.runtime.layers.base import Layer
from robotcore.runtime.layers.guardian import guard_motors
from robotcore.runtime.loop import Loop
from robotcore.runtime.observer import Observer, Run
from robotcore.runtime.plan import Plan, RunRequest
from robotcore.runtime.result import Outcome, RunResult, outcome_of
from robotcore.runtime.run_end import RunEnd, build_result
from robotcore.runtime.signals import SignalGuard, WatchdogInterrupt
from robotcore.runtime.time_limits import (
    SIMULATION_FACTOR,
    close_limit,
    judge_limit,
    observer_limit,
    open_limit,
    step_limit,
)
from robotcore.runtime.verification import Verification, verify_run
from robotcore.safety import ActivityMonitor, EmergencyStop, Watchdog
from robotcore.safety.motor_stop import STOP_S
from robotcore.safety.reserve import Reserve

SHUTDOWN_GRACE_S = 0.2
"""When a process must end, closing what hangs, and each of those who want to hear of it, get this long."""

SHUTDOWN_THREADS = 4
"""What may hang when a process must end, each in a thread of its own: latching, closing, the observers, last words."""

WAKE_UP_S = 0.3
"""A sensor that was suspended too has a new sample after this."""


class _NoAnswerError(Exception):
    """A robot cannot be closed; why has been told already."""


class RunSession:
    """A run that is to be."""

    def __init__(
        self,
        plan: Plan,
        observers: Sequence[Observer],
        taps: Sequence[Layer],
        interrupts: SignalGuard,
        on_forced_exit: Callable[[RunResult], object],
        timeout_scale: float,
    ) -> None:
        self._plan, self._observers, self._taps, self._interrupts = plan, observers, taps, interrupts
        self._last_words = on_forced_exit
        self._wall, self._activity = MonotonicClock(), ActivityMonitor()
        timeout_scale *= SIMULATION_FACTOR if plan.request.gui else 1.0
        self._reserve = Reserve(self._wall)
        self._watchdog = Watchdog(
            self._activity, self._on_timeout, self._force_exit, self._reserve, timeout_scale, self._note_tracer
        )
        self._closing = close_limit(plan.backend.name)
        self._timeout_error: RobotcoreError | None = None
        self._assembled: Assembled | None = None
        self._guard = ExitStack()
        self._loop: Loop | None = None
        self._verification = Verification()
        self._late_failure: RobotcoreError | None = None
        self._is_unanswered = False

    def result(self) -> RunResult:
        """Run to the end, whichever it is, and tell the observers too."""
        try:
            return self._run_to_result()
        finally:
            with suppress(MemoryError):
                self._reserve.close()

    def _run_to_result(self) -> RunResult:
        error: RobotcoreError | Interrupted | None = None
        try:
            outcome = self._run_under_watchdog()
        except (RobotcoreError, Interrupted) as caught:
            error, outcome = caught, outcome_of(caught)
        except MemoryError as short:
            error = _cause_of(short) or ResourceError("the program is out of memory")
            outcome = outcome_of(error)
        except WatchdogInterrupt:  # too late for the loop to tell why
            error = self._latched_error
            outcome = outcome_of(error)
        except BaseException as bug:
            self._notify_observers(self._build_result(RobotcoreError(f"{type(bug).__name__}: {bug}"), Outcome.ERROR))
            raise
        if self._late_failure and error is None:
            error, outcome = self._late_failure, Outcome.ERROR
        result = self._build_result(error, outcome)
        if failures := self._notify_observers(result):
            raise failures[0]
        return result

    def _run_under_watchdog(self) -> Outcome:
        self._reserve.hold(SHUTDOWN_THREADS)
        self._watchdog.start()
        try:
            return self._run_and_close()
        finally:
            self._watchdog.close()

    def _run_and_close(self) -> Outcome:
        raw = robot = self._open_robot()
        outcome = Outcome.ERROR
        try:
            self._assembled = assembled = self._assemble(raw)
            robot = assembled.robot
            outcome = self._run(assembled, self._truth_of(raw))
        finally:
            self._reserve.release_memory()
            try:
                self._interrupts.mask()
                self._stop(raw)
                self._judge(raw, outcome)
            finally:  # even where a signal came just before the hold
                self._interrupts.mask()
                self._close(robot)
        return outcome

    def _open_robot(self) -> Robot:
        plan = self._plan
        self._activity.begin(open_limit(plan.backend.name))
        raw = plan.backend.open(plan.setup)
        self._activity.begin(None)
        self._plan = replace(plan, notes=(*plan.notes, *raw.notes))
        return raw

    def _run(self, assembled: Assembled, truth: Truth | None) -> Outcome:
        plan, safety = self._plan, self._plan.description.safety
        stop = EmergencyStop(assembled.latch)
        self._loop = Loop(
            assembled,
            plan.behaviour,
            plan.request.rate_hz,
            plan.request.timeout_s,
            [*(observer.tick for observer in self._observers), lambda _: self._interrupts.check()],
            step_limit(plan.behaviour, safety.watchdog_s),
            observer_limit(safety.watchdog_s * (SIMULATION_FACTOR if assembled.robot.clock.is_lockstep else 1.0)),
            safety.outage_s,
        )
        self._interrupts.stop_with(self._last_resort)
        self._interrupts.suspend_with(partial(assembled.halt, "suspension"), self._wait_for_sensors, is_to_wait=True)
        run = Run(plan.request, plan.behaviour, plan.description, plan.world, assembled.robot, truth, stop, plan.faults)
        with self._interrupts.defer():
            for observer in self._observers:
                observer.begin(run)
        return self._loop.run()

    def _wait_for_sensors(self) -> None:
        """Wait until what is polled has something newer than from before the suspension, which would be stale."""
        self._wall.sleep_until(self._wall.now() + WAKE_UP_S)

    def _assemble(self, raw: Robot) -> Assembled:
        plan, clock = self._plan, self._clock_for(raw)
        seed, rate_hz = plan.setup.seed, plan.request.rate_hz
        faults = [fault.layer(clock, seed) for fault in plan.faults]
        guard = guard_motors(raw, plan.description.safety.lease_ticks / rate_hz, self._guard)
        assembled = assemble(
            raw,
            plan.description,
            rate_hz,
            clock,
            plan.conditions,
            seed,
            faults,
            self._taps,
            guard,
            self._activity,
            self._reserve,
        )
        self._reserve.hold(len(raw.motors))
        clock.prepare_calls()
        return assembled

    def _clock_for(self, raw: Robot) -> Clock:
        is_paced = self._plan.request.realtime or self._plan.request.gui
        return PacedClock(raw.clock) if is_paced and raw.clock.is_lockstep else raw.clock

    def _truth_of(self, raw: Robot) -> Truth | None:
        if raw.truth is None or self._plan.world is None:
            return None
        return Truth(raw.truth, self._plan.description, self._plan.world)

    def _stop(self, raw: Robot) -> None:
        """Stop the motors before anything else runs, and let nothing move any more, whatever threads an app has left.

        A stop that fails is told when it fails again at closing; one that hangs, now. Where time stands meanwhile, and
        so the motors, it may take as long as any answer: a simulator on a busy machine is only slow.
        """
        if assembled := self._assembled:
            self._activity.begin(self._closing)
            assembled.latch.set(DeviceClosedError(raw.name))
            may_be_slow = raw.clock.is_lockstep and not self._is_unanswered
            failures = assembled.brakes.apply_apart(self._plan.description.safety.answer_s if may_be_slow else STOP_S)
            if assembled.brakes.are_hung and not self._is_unanswered:
                self._late_failure = next((each for each in failures if isinstance(each, DeviceError)), None)

    def _judge(self, raw: Robot, outcome: Outcome) -> None:
        """Ask the truth while the simulator lives; one that has died has no word."""
        if not self._is_unanswered:
            plan = self._plan
            self._activity.begin(judge_limit(plan.judge, plan.backend.name))
            self._verification = verify_run(plan.judge, self._truth_of(raw), outcome, plan.request.judge)
            self._late_failure = self._late_failure or self._verification.failure

    def _close(self, robot: Robot) -> None:
        """Close the robot; a guardian stops what cannot be closed."""
        self._activity.begin(self._closing)
        try:
            with suppress(_NoAnswerError), self._guard:
                self._close_robot(robot)
        except RobotcoreError as failure:
            self._late_failure = failure

    def _close_robot(self, robot: Robot) -> None:
        """Close the robot; one that does not answer is not waited for."""
        if not (self._is_unanswered or (self._assembled and self._assembled.brakes.are_hung)):
            robot.close()
            return
        closing = self._reserve.call(robot.close)
        if not closing.is_done_within(SHUTDOWN_GRACE_S) or closing.failure:
            raise _NoAnswerError

    @property
    def _latched_error(self) -> RobotcoreError:
        """What latched first, where something was there to latch."""
        error = (self._assembled and self._assembled.latch.error) or self._timeout_error
        assert error
        return error

    def _on_timeout(self, error: RobotcoreError) -> None:
        """Stop what moves, for the loop's thread does not come back, and call it."""
        self._timeout_error = error
        self._is_unanswered = isinstance(error, (BackendError, DeviceError))
        try:
            if self._assembled:
                self._assembled.latch.set(error)
        finally:
            self._interrupts.interrupt_main_thread()

    def _note_tracer(self, error: RobotcoreError) -> None:
        """Say, once, that the watchdog would have ended the run."""
        note = f"the watchdog did not end the run, for a debugger or another tracer is active: {error}"
        self._plan = replace(self._plan, notes=(*self._plan.notes, note))
        with suppress(OSError):
            os.write(2, f"note: {note}\n".encode())

    def _force_exit(self, error: RobotcoreError) -> None:
        """End the process, which nothing else ends; but not one whose main thread has other things to do."""
        if self._interrupts.is_in_main_thread:
            try:
                self._reserve.release_memory()
                self._report_forced_exit(error, len(self._loop.unreported_interventions) if self._loop else 0)
            finally:
                os._exit(error.exit_status)

    def _last_resort(self) -> None:
        """Stop for good, for the process ends; not in this thread, which may be in the middle of a call that hangs."""
        assert self._assembled
        self._reserve.release_memory()
        try:
            latching = partial(self._assembled.latch.set, DeviceClosedError(self._assembled.robot.name))
            self._reserve.call(latching).is_done_within(SHUTDOWN_GRACE_S)
        finally:
            try:
                self._assembled.brakes.apply_apart()
            finally:
                if self._interrupts.raised:
                    self._report_forced_exit(self._interrupts.raised)

    def _report_forced_exit(self, error: RobotcoreError | Interrupted, unreported: int = 0) -> None:
        """Tell everyone how the run ends, while there is still somebody to; of interventions also those untold."""
        result = self._build_result(error, outcome_of(error))
        result = replace(result, interventions=result.interventions + unreported)
        for hear in (partial(self._notify_observers, result), partial(self._last_words, result)):
            self._reserve.call(hear).is_done_within(SHUTDOWN_GRACE_S)

    def _notify_observers(self, result: RunResult) -> list[Exception]:
        """Tell every observer the end, each on its own; return what was raised."""
        failures = []
        for observer in self._observers:
            try:
                observer.end(result)
            except Exception as failure:  # noqa: BLE001, PERF203  the others are to hear it too
                failures.append(failure)
        return failures

    def _build_result(self, error: RobotcoreError | Interrupted | None, outcome: Outcome) -> RunResult:
        ending = RunEnd(outcome, error, self._late_failure)
        return build_result(self._plan, self._loop, self._verification, ending, self._wall.now())


def _cause_of(error: BaseException) -> RobotcoreError | Interrupted | None:
    """Return what was ending the run when memory ran out, if something was."""
    while context := error.__context__:
        if isinstance(context, (RobotcoreError, Interrupted)):
            return context
        error = context
    return None


__all__ = ["Observer", "Run", "RunRequest", "RunResult", "run"]


def _print_reason(result: RunResult) -> None:
    """Say on standard error why the process ends; a stream of Python's may be held by what hangs."""
    os.write(2, f"error: {result.reason}\n".encode())


def run(
    request: RunRequest,
    observers: Sequence[Observer] = (),
    taps: Sequence[Layer] = (),
    *,
    on_forced_exit: Callable[[RunResult], object] = _print_reason,
    timeout_scale: float = 1.0,
) -> RunResult:
    """Run an app and return its result.

    observers: they get the run's beginning, each tick and the result.
    taps: layers that see every sample that the app gets and every command that it gives.
    on_forced_exit: if an app or a driver hangs and cannot be interrupted, the process exits. This function is called
    first with the result, in another thread.
    timeout_scale: a factor on every time limit of the run.

    Raises UsageError and BackendMissingError before anything is opened. A later error is in the result, and every
    motor is stopped.
    """
    plan = Plan.of(request)
    with SignalGuard() as interrupts:
        return RunSession(plan, observers, taps, interrupts, on_forced_exit, timeout_scale).result()
