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
from robotcore.runtime.layers.guardian import guarded
from robotcore.runtime.loop import Loop
from robotcore.runtime.observer import Observer, Run
from robotcore.runtime.plan import Plan, RunRequest
from robotcore.runtime.result import Ending, Outcome, RunResult, outcome_of, told
from robotcore.runtime.signals import Interrupts, Recalled
from robotcore.runtime.time_limits import SIMULATED, closing, judging, opening, stepping, watching
from robotcore.runtime.verification import Judgement, judged
from robotcore.safety import EmergencyStop, Watchdog, Whereabouts
from robotcore.safety.motor_stop import STOP_S
from robotcore.safety.reserve import Reserve

FAREWELL_S = 0.2
"""When a process must end, closing what hangs, and each of those who want to hear of it, get this long."""

ENDING_THREADS = 4
"""What may hang when a process must end, each in a thread of its own: latching, closing, the observers, last words."""

WAKING_S = 0.3
"""A sensor that was suspended too has a new sample after this."""


class _UnansweredError(Exception):
    """A robot cannot be closed; why has been told already."""


class Execution:
    """A run that is to be."""

    def __init__(
        self,
        plan: Plan,
        observers: Sequence[Observer],
        taps: Sequence[Layer],
        interrupts: Interrupts,
        last_words: Callable[[RunResult], object],
        patience: float,
    ) -> None:
        self._plan, self._observers, self._taps, self._interrupts = plan, observers, taps, interrupts
        self._last_words = last_words
        self._wall, self._where = MonotonicClock(), Whereabouts()
        patience *= SIMULATED if plan.request.gui else 1.0
        self._reserve = Reserve(self._wall)
        self._watchdog = Watchdog(self._where, self._bite, self._end_hard, self._reserve, patience, self._note_tracer)
        self._closing = closing(plan.backend.name)
        self._bitten: RobotcoreError | None = None
        self._assembled: Assembled | None = None
        self._guard = ExitStack()
        self._loop: Loop | None = None
        self._judgement = Judgement()
        self._late_failure: RobotcoreError | None = None
        self._is_unanswered = False

    def result(self) -> RunResult:
        """Run to the end, whichever it is, and tell the observers too."""
        try:
            return self._result()
        finally:
            with suppress(MemoryError):
                self._reserve.close()

    def _result(self) -> RunResult:
        error: RobotcoreError | Interrupted | None = None
        try:
            outcome = self._watched()
        except (RobotcoreError, Interrupted) as caught:
            error, outcome = caught, outcome_of(caught)
        except MemoryError as short:
            error = _cause_of(short) or ResourceError("the program is out of memory")
            outcome = outcome_of(error)
        except Recalled:  # too late for the loop to tell why
            error = self._why_recalled
            outcome = outcome_of(error)
        except BaseException as bug:
            self._tell(self._told(RobotcoreError(f"{type(bug).__name__}: {bug}"), Outcome.ERROR))
            raise
        if self._late_failure and error is None:
            error, outcome = self._late_failure, Outcome.ERROR
        result = self._told(error, outcome)
        if failures := self._tell(result):
            raise failures[0]
        return result

    def _watched(self) -> Outcome:
        self._reserve.hold(ENDING_THREADS)
        self._watchdog.start()
        try:
            return self._run_and_close()
        finally:
            self._watchdog.close()

    def _run_and_close(self) -> Outcome:
        raw = robot = self._opened()
        outcome = Outcome.ERROR
        try:
            self._assembled = assembled = self._assemble(raw)
            robot = assembled.robot
            outcome = self._run(assembled, self._truth_of(raw))
        finally:
            self._reserve.release_memory()
            try:
                self._interrupts.hold()
                self._stop(raw)
                self._judge(raw, outcome)
            finally:  # even where a signal came just before the hold
                self._interrupts.hold()
                self._close(robot)
        return outcome

    def _opened(self) -> Robot:
        plan = self._plan
        self._where.begin(opening(plan.backend.name))
        raw = plan.backend.open(plan.setup)
        self._where.begin(None)
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
            stepping(plan.behaviour, safety.watchdog_s),
            watching(safety.watchdog_s * (SIMULATED if assembled.robot.clock.is_lockstep else 1.0)),
            safety.outage_s,
        )
        self._interrupts.stop_with(self._last_resort)
        self._interrupts.suspend_with(partial(assembled.halt, "suspension"), self._let_sensors_wake, is_to_wait=True)
        run = Run(plan.request, plan.behaviour, plan.description, plan.world, assembled.robot, truth, stop, plan.faults)
        with self._interrupts.put_off():
            for observer in self._observers:
                observer.begin(run)
        return self._loop.run()

    def _let_sensors_wake(self) -> None:
        """Wait until what is polled has something newer than from before the suspension, which would be stale."""
        self._wall.sleep_until(self._wall.now() + WAKING_S)

    def _assemble(self, raw: Robot) -> Assembled:
        plan, clock = self._plan, self._clock_for(raw)
        seed, rate_hz = plan.setup.seed, plan.request.rate_hz
        faults = [fault.layer(clock, seed) for fault in plan.faults]
        guard = guarded(raw, plan.description.safety.lease_ticks / rate_hz, self._guard)
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
            self._where,
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
            self._where.begin(self._closing)
            assembled.latch.set(DeviceClosedError(raw.name))
            may_be_slow = raw.clock.is_lockstep and not self._is_unanswered
            failures = assembled.brakes.apply_apart(self._plan.description.safety.answer_s if may_be_slow else STOP_S)
            if assembled.brakes.are_hung and not self._is_unanswered:
                self._late_failure = next((each for each in failures if isinstance(each, DeviceError)), None)

    def _judge(self, raw: Robot, outcome: Outcome) -> None:
        """Ask the truth while the simulator lives; one that has died has no word."""
        if not self._is_unanswered:
            plan = self._plan
            self._where.begin(judging(plan.judge, plan.backend.name))
            self._judgement = judged(plan.judge, self._truth_of(raw), outcome, plan.request.judge)
            self._late_failure = self._late_failure or self._judgement.failure

    def _close(self, robot: Robot) -> None:
        """Close the robot; a guardian stops what cannot be closed."""
        self._where.begin(self._closing)
        try:
            with suppress(_UnansweredError), self._guard:
                self._let_go(robot)
        except RobotcoreError as failure:
            self._late_failure = failure

    def _let_go(self, robot: Robot) -> None:
        """Close the robot; one that does not answer is not waited for."""
        if not (self._is_unanswered or (self._assembled and self._assembled.brakes.are_hung)):
            robot.close()
            return
        closing = self._reserve.call(robot.close)
        if not closing.is_done_within(FAREWELL_S) or closing.failure:
            raise _UnansweredError

    @property
    def _why_recalled(self) -> RobotcoreError:
        """What latched first, where something was there to latch."""
        error = (self._assembled and self._assembled.latch.error) or self._bitten
        assert error
        return error

    def _bite(self, error: RobotcoreError) -> None:
        """Stop what moves, for the loop's thread does not come back, and call it."""
        self._bitten = error
        self._is_unanswered = isinstance(error, (BackendError, DeviceError))
        try:
            if self._assembled:
                self._assembled.latch.set(error)
        finally:
            self._interrupts.recall()

    def _note_tracer(self, error: RobotcoreError) -> None:
        """Say, once, that the watchdog would have ended the run."""
        note = f"the watchdog did not end the run, for a debugger or another tracer is active: {error}"
        self._plan = replace(self._plan, notes=(*self._plan.notes, note))
        with suppress(OSError):
            os.write(2, f"note: {note}\n".encode())

    def _end_hard(self, error: RobotcoreError) -> None:
        """End the process, which nothing else ends; but not one whose main thread has other things to do."""
        if self._interrupts.are_heard:
            try:
                self._reserve.release_memory()
                self._farewell(error, len(self._loop.untold) if self._loop else 0)
            finally:
                os._exit(error.exit_status)

    def _last_resort(self) -> None:
        """Stop for good, for the process ends; not in this thread, which may be in the middle of a call that hangs."""
        assert self._assembled
        self._reserve.release_memory()
        try:
            latching = partial(self._assembled.latch.set, DeviceClosedError(self._assembled.robot.name))
            self._reserve.call(latching).is_done_within(FAREWELL_S)
        finally:
            try:
                self._assembled.brakes.apply_apart()
            finally:
                if self._interrupts.raised:
                    self._farewell(self._interrupts.raised)

    def _farewell(self, error: RobotcoreError | Interrupted, untold: int = 0) -> None:
        """Tell everyone how the run ends, while there is still somebody to; of interventions also those untold."""
        result = self._told(error, outcome_of(error))
        result = replace(result, interventions=result.interventions + untold)
        for hear in (partial(self._tell, result), partial(self._last_words, result)):
            self._reserve.call(hear).is_done_within(FAREWELL_S)

    def _tell(self, result: RunResult) -> list[Exception]:
        """Tell every observer the end, each on its own; return what was raised."""
        failures = []
        for observer in self._observers:
            try:
                observer.end(result)
            except Exception as failure:  # noqa: BLE001, PERF203  the others are to hear it too
                failures.append(failure)
        return failures

    def _told(self, error: RobotcoreError | Interrupted | None, outcome: Outcome) -> RunResult:
        ending = Ending(outcome, error, self._late_failure)
        return told(self._plan, self._loop, self._judgement, ending, self._wall.now())


def _cause_of(error: BaseException) -> RobotcoreError | Interrupted | None:
    """Return what was ending the run when memory ran out, if something was."""
    while context := error.__context__:
        if isinstance(context, (RobotcoreError, Interrupted)):
            return context
        error = context
    return None


__all__ = ["Observer", "Run", "RunRequest", "RunResult", "run"]


def _say(result: RunResult) -> None:
    """Say on standard error why the process ends; a stream of Python's may be held by what hangs."""
    os.write(2, f"error: {result.reason}\n".encode())


def run(
    request: RunRequest,
    observers: Sequence[Observer] = (),
    taps: Sequence[Layer] = (),
    *,
    last_words: Callable[[RunResult], object] = _say,
    patience: float = 1.0,
) -> RunResult:
    """Run an app and tell how it ended; ``taps`` are layers that see all that goes to the app and comes from it.

    Raises UsageError and BackendMissingError before anything is opened. What happens from then on is in the result,
    and every motor is stopped. An app or a driver that does not come back ends the process, where it cannot be
    interrupted: ``last_words`` is then called with the result, from another thread. Every limit on how long something
    may take is ``patience`` times as long.
    """
    plan = Plan.of(request)
    with Interrupts() as interrupts:
        return Execution(plan, observers, taps, interrupts, last_words, patience).result()
