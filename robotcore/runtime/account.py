"""What is told of a run when it has ended."""

from __future__ import annotations

from typing import NamedTuple

from robotcore.errors import Interrupted, RobotcoreError, SafetyStop
from robotcore.runtime.apps import app_name
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.judging import Judgement
from robotcore.runtime.loop import Loop
from robotcore.runtime.outcome import Outcome, RunResult
from robotcore.runtime.plan import Plan, RunRequest


class Ending(NamedTuple):
    """How a run ended: ``error`` ended it, if one did; ``late`` is what failed when it was over."""

    outcome: Outcome
    error: RobotcoreError | Interrupted | None
    late: RobotcoreError | None


def outcome_of(error: RobotcoreError | Interrupted) -> Outcome:
    """Return the outcome of a run that this ended."""
    if isinstance(error, Interrupted):
        return Outcome.INTERRUPTED
    return Outcome.STOPPED if isinstance(error, SafetyStop) else Outcome.ERROR


def told(plan: Plan, loop: Loop | None, judgement: Judgement, ending: Ending, wall_time: float) -> RunResult:
    """Return all that is known of a run; ``loop`` is None where none began."""
    request, behaviour, (outcome, error, late) = plan.request, plan.behaviour, ending
    said = str(error) if error else behaviour.reason or _default_reason(outcome, request, behaviour)
    verified = False if error and judgement.verified else judgement.verified
    return RunResult(
        app=app_name(request.app),
        backend=plan.backend.name,
        robot=plan.description.name,
        world=plan.world.name if plan.world else None,
        seed=request.seed,
        outcome=outcome,
        exit_status=error.exit_status if error else int(outcome is not Outcome.SUCCESS or verified is False),
        reason=f"{said}; {late}" if late and late is not error else said,
        verified=verified,
        judge=app_name(request.judge) if request.judge else None,
        sim_time_s=round(loop.time, 6) if loop else 0.0,
        wall_time_s=round(wall_time, 3),
        ticks=loop.trace.ticks if loop else 0,
        overruns=loop.overruns if loop else 0,
        contacts=judgement.contacts,
        distance_to_target_m=judgement.distance,
        interventions=loop.trace.interventions if loop else 0,
        milestones=dict(loop.trace.milestones) if loop else {},
        conditions=plan.drawn,
        faults=[str(fault) for fault in plan.faults],
        notes=[*plan.notes, *((*loop.trace.warnings, *loop.outages.notes(loop.time)) if loop else ())],
        batteries=dict(loop.trace.batteries) if loop else {},
        trace_sha256=loop.trace.sha256 if loop else None,
        error=error,
    )


def _default_reason(outcome: Outcome, request: RunRequest, behaviour: Behaviour) -> str:
    return f"not done after {request.timeout_s:g} s, in {behaviour.state!r}" if outcome is Outcome.TIMEOUT else ""
