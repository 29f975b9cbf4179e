"""Builds the result of a run from its loop and its verification."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from robotcore.errors import Interrupted, RobotcoreError
from robotcore.hal.robot import Robot
from robotcore.runtime.apps import app_name
from robotcore.runtime.layers.devices import AppActuator
from robotcore.runtime.loop import Loop
from robotcore.runtime.plan import Plan
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.success_verification import Verification
from robotcore.runtime.tick_statistics import TickStatistics
from robotcore.safety.range_guard import RangeGuard


def build_result(
    plan: Plan,
    outcome: Outcome,
    error: RobotcoreError | Interrupted | None,
    late_failure: RobotcoreError | None,
    verification: Verification,
    loop: Loop | None,
    statistics: TickStatistics,
    notes: Sequence[str],
    wall_time_s: float,
) -> RunResult:
    """Return the result of a run.

    error: the error that ended the run.
    late_failure: the first error after the loop, such as a robot that could not be closed.
    loop: the loop of the run. None if the robot could not be opened.
    """
    request = plan.request
    reason = str(error) if error else loop.reason if loop else ""
    if outcome is Outcome.TIMEOUT and loop and not reason:
        reason = _explain_timeout(plan, loop)
    if late_failure and late_failure is not error:
        reason = f"{reason}; {late_failure}"
    verified = False if error and verification.verified else verification.verified
    result = RunResult(
        app=app_name(request.app_reference),
        backend=plan.backend.name,
        robot=plan.description.name,
        world=plan.world.name if plan.world else None,
        seed=request.seed,
        outcome=outcome,
        exit_status=error.exit_status if error else int(outcome is not Outcome.SUCCESS or verified is False),
        reason=reason,
        verified=verified,
        judge=app_name(request.judge) if request.judge else None,
        wall_time_s=round(wall_time_s, 3),
        contacts=verification.contacts,
        distance_to_target_m=verification.distance,
        conditions=plan.drawn,
        faults=[str(fault) for fault in plan.faults],
        notes=[*notes],
        ideal=request.ideal,
        error=error,
    )
    if not loop:
        return result
    return replace(
        result,
        sim_time_s=round(loop.time, 6),
        ticks=loop.trace.ticks,
        overruns=loop.overruns,
        tick_times_us=statistics.summarise(),
        interventions=loop.trace.interventions,
        intervention_s=loop.intervention_timer.measure(),
        milestones=dict(loop.trace.milestones),
        notes=[*notes, *loop.trace.warnings, *loop.losses.summarise(loop.time), *_describe_limits(loop.robot)],
        batteries=dict(loop.trace.voltages),
        trace_sha256=loop.trace.sha256,
    )


def _explain_timeout(plan: Plan, loop: Loop) -> str:
    reason = f"not done after {plan.request.timeout_s:g} s, in state {plan.behaviour.state!r}"
    if loop.intervention_timer.measure().get(RangeGuard.cause, 0.0) < loop.time / 2:
        return reason
    sensors = " or ".join(sensor.name for sensor in plan.description.sensors_ahead)
    place = f"{plan.description.guard_distance_m:.2f} m in front of an obstacle"
    return (
        f"{reason}. The range guard stops the robot {place}, measured by {sensors}. Let the app stop before that. "
        "An app that touches obstacles needs a robot without such a sensor"
    )


def _describe_limits(robot: Robot) -> Iterator[str]:
    yield from filter(
        None, (each.describe_limits() for each in robot.devices.values() if isinstance(each, AppActuator))
    )
