"""The one place that composes a run: descriptions, backend, layers, loop."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

from robotcore.behaviour import Behaviour
from robotcore.catalogue import app_name
from robotcore.clock import Clock, MonotonicClock, PacedClock
from robotcore.description import RobotDescription, WorldDescription
from robotcore.errors import BehaviourError, Interrupted, RobotcoreError, SafetyStop
from robotcore.interrupts import Interrupts
from robotcore.judging import verdict
from robotcore.layers import Assembled, assemble
from robotcore.layers.layer import Layer
from robotcore.loop import Loop
from robotcore.outcome import Outcome, RunResult
from robotcore.plan import Plan, RunRequest
from robotcore.robot import Robot
from robotcore.trace import TickRecord
from robotcore.truth import Truth

__all__ = ["Observer", "Run", "RunRequest", "RunResult", "run"]


@dataclass(frozen=True)
class Run:
    """A run as an observer sees it. Reading a device here would steer the run: look at ``latest`` instead."""

    request: RunRequest
    behaviour: Behaviour
    description: RobotDescription
    world: WorldDescription | None
    robot: Robot
    truth: Truth | None


class Observer(Protocol):
    """Looks at a run: from its first tick, at each, and at its result."""

    def begin(self, run: Run) -> None: ...
    def tick(self, record: TickRecord) -> None: ...
    def end(self, result: RunResult) -> None: ...


def run(request: RunRequest, observers: Sequence[Observer] = (), taps: Sequence[Layer] = ()) -> RunResult:
    """Run an app and tell how it ended; ``taps`` are layers that see all that goes to the app and comes from it.

    Raises UsageError and BackendMissingError before anything is opened. What happens from then on is in the result,
    and every motor is stopped.
    """
    plan = Plan.of(request)
    with Interrupts() as interrupts:
        return _Execution(plan, observers, taps, interrupts).result()


@dataclass(frozen=True)
class _Judgement:
    """What the truth says at the end; None is what nobody knows."""

    verified: bool | None = None
    contacts: int | None = None
    distance: float | None = None


class _Execution:
    """One run from opening to closing."""

    def __init__(
        self, plan: Plan, observers: Sequence[Observer], taps: Sequence[Layer], interrupts: Interrupts
    ) -> None:
        self._plan, self._observers, self._taps, self._interrupts = plan, observers, taps, interrupts
        self._loop: Loop | None = None
        self._sim_time = 0.0
        self._judgement = _Judgement()
        self._late_failure: RobotcoreError | None = None

    def result(self) -> RunResult:
        """Run to the end, whichever it is, and tell the observers too."""
        wall = MonotonicClock()
        error: RobotcoreError | Interrupted | None = None
        try:
            outcome = self._run_and_close()
        except (RobotcoreError, Interrupted) as caught:
            error, outcome = caught, _outcome_of(caught)
        if self._late_failure and error is None:
            error, outcome = self._late_failure, Outcome.ERROR
        result = self._told(outcome, error, wall.now())
        for observer in self._observers:
            observer.end(result)
        return result

    def _run_and_close(self) -> Outcome:
        raw = robot = self._plan.backend.open(self._plan.setup)
        outcome = Outcome.ERROR
        try:
            assembled = self._assembled(raw)
            robot = assembled.robot
            self._interrupts.stop_with(robot.stop)
            outcome = self._run(assembled, self._truth_of(raw))
            return outcome
        finally:
            try:
                self._interrupts.hold()
                self._stop(robot)
                self._judge(raw, outcome)
            finally:  # even where a signal came just before the hold
                self._interrupts.hold()
                self._close(robot)

    def _run(self, assembled: Assembled, truth: Truth | None) -> Outcome:
        plan = self._plan
        run = Run(plan.request, plan.behaviour, plan.description, plan.world, assembled.robot, truth)
        for observer in self._observers:
            observer.begin(run)
        self._loop = Loop(
            assembled,
            plan.behaviour,
            plan.request.rate_hz,
            plan.request.timeout_s,
            [*(observer.tick for observer in self._observers), lambda _: self._interrupts.check()],
        )
        try:
            return self._loop.run()
        finally:
            self._sim_time = assembled.clock.now()

    def _assembled(self, raw: Robot) -> Assembled:
        plan, clock = self._plan, self._clock_for(raw)
        seed, rate_hz = plan.setup.seed, plan.request.rate_hz
        faults = [fault.layer(clock, seed) for fault in plan.faults]
        return assemble(raw, plan.description, rate_hz, clock, plan.conditions, seed, faults, self._taps)

    def _clock_for(self, raw: Robot) -> Clock:
        is_paced = self._plan.request.realtime or self._plan.request.gui
        return PacedClock(raw.clock) if is_paced and self._plan.backend.is_lockstep else raw.clock

    def _truth_of(self, raw: Robot) -> Truth | None:
        if raw.truth is None or self._plan.world is None:
            return None
        return Truth(raw.truth, self._plan.description, self._plan.world)

    def _judge(self, raw: Robot, outcome: Outcome) -> None:
        """Ask the truth while the simulator lives; one that has died has no word."""
        try:
            if truth := self._truth_of(raw):
                self._judgement = _Judgement(None, truth.contacts, truth.distance_to_target)
                said = verdict(self._plan.judge, truth, self._plan.request.judge)
                verified = said and outcome is Outcome.SUCCESS
                self._judgement = replace(self._judgement, verified=verified)
        except BehaviourError as error:  # the robot must still be closed
            self._late_failure = error
        except RobotcoreError:
            self._judgement = _Judgement()

    @staticmethod
    def _stop(robot: Robot) -> None:
        """Stop the motors before anything else runs; one that fails is told when it fails again at closing."""
        with suppress(RobotcoreError):
            robot.stop()

    def _close(self, robot: Robot) -> None:
        try:
            robot.close()
        except RobotcoreError as failure:
            self._late_failure = failure

    def _told(self, outcome: Outcome, error: RobotcoreError | Interrupted | None, wall_time: float) -> RunResult:
        request, behaviour, loop = self._plan.request, self._plan.behaviour, self._loop
        said = str(error) if error else behaviour.reason or _default_reason(outcome, request, behaviour)
        late = self._late_failure
        verified = False if error and self._judgement.verified else self._judgement.verified
        return RunResult(
            app=app_name(request.app),
            backend=self._plan.backend.name,
            robot=self._plan.description.name,
            world=self._plan.world.name if self._plan.world else None,
            seed=request.seed,
            outcome=outcome,
            exit_status=error.exit_status if error else int(outcome is not Outcome.SUCCESS or verified is False),
            reason=f"{said}; {late}" if late and late is not error else said,
            verified=verified,
            judge=app_name(request.judge) if request.judge else None,
            sim_time_s=round(self._sim_time, 6),
            wall_time_s=round(wall_time, 3),
            ticks=loop.trace.ticks if loop else 0,
            overruns=loop.overruns if loop else 0,
            contacts=self._judgement.contacts,
            distance_to_target_m=self._judgement.distance,
            interventions=loop.trace.interventions if loop else 0,
            milestones=dict(loop.trace.milestones) if loop else {},
            conditions=self._plan.drawn,
            faults=[str(fault.spec) for fault in self._plan.faults],
            trace_sha256=loop.trace.sha256 if loop else None,
            error=error,
        )


def _outcome_of(error: RobotcoreError | Interrupted) -> Outcome:
    if isinstance(error, Interrupted):
        return Outcome.INTERRUPTED
    return Outcome.STOPPED if isinstance(error, SafetyStop) else Outcome.ERROR


def _default_reason(outcome: Outcome, request: RunRequest, behaviour: Behaviour) -> str:
    return f"not done after {request.timeout_s:g} s, in {behaviour.state!r}" if outcome is Outcome.TIMEOUT else ""
