"""Builds the result of a run from the plan, the loop, the verification and the errors at the end."""

from __future__ import annotations

from robotcore.errors import Interrupted, RobotcoreError
from robotcore.runtime.apps import app_name
from robotcore.runtime.loop import Loop
from robotcore.runtime.plan import Plan
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.success_verification import Verification


def build_result(
    plan: Plan,
    loop: Loop | None,
    verification: Verification,
    outcome: Outcome,
    error: RobotcoreError | Interrupted | None,
    late_error: RobotcoreError | None,
    wall_time: float,
) -> RunResult:
    """Return the result of a run.

    loop: the loop of the run; None if the run ended before its first tick.
    error: the error that ended the run, if one did.
    late_error: an error after the last tick, for example while the robot was closed.
    wall_time: the duration of the run, in seconds.
    """
    request, behaviour = plan.request, plan.behaviour
    late = f"not done after {request.timeout_s:g} s, in {behaviour.state!r}" if outcome is Outcome.TIMEOUT else ""
    reason = str(error) if error else behaviour.reason or late
    verified = False if error and verification.verified else verification.verified
    return RunResult(
        app=app_name(request.app_reference),
        backend=plan.backend.name,
        robot=plan.description.name,
        world=plan.world.name if plan.world else None,
        seed=request.seed,
        outcome=outcome,
        exit_status=error.exit_status if error else int(outcome is not Outcome.SUCCESS or verified is False),
        reason=f"{reason}; {late_error}" if late_error and late_error is not error else reason,
        verified=verified,
        judge=app_name(request.judge) if request.judge else None,
        sim_time_s=round(loop.time, 6) if loop else 0.0,
        wall_time_s=round(wall_time, 3),
        ticks=loop.trace.ticks if loop else 0,
        overruns=loop.overruns if loop else 0,
        contacts=verification.contacts,
        distance_to_target_m=verification.distance,
        interventions=loop.trace.interventions if loop else 0,
        intervention_s=loop.intervention_timer.measure() if loop else {},
        milestones=dict(loop.trace.milestones) if loop else {},
        conditions=plan.drawn,
        faults=[str(fault) for fault in plan.faults],
        notes=[*plan.notes, *((*loop.trace.warnings, *loop.losses.summarise(loop.time)) if loop else ())],
        batteries=dict(loop.trace.batteries) if loop else {},
        trace_sha256=loop.trace.sha256 if loop else None,
        error=error,
    )
