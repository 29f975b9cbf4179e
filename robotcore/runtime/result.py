"""The result of a run: its outcome and all that was measured."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, fields
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from robotcore.errors import Interrupted, RobotcoreError, SafetyStop
from robotcore.runtime.apps import app_name

if TYPE_CHECKING:
    from robotcore.runtime.behaviour import Behaviour
    from robotcore.runtime.loop import Loop
    from robotcore.runtime.plan import Plan, RunRequest
    from robotcore.runtime.verification import Verification


class Outcome(str, Enum):
    """What the app and the loop say of a run."""

    SUCCESS = "success"
    FAILURE = "failure"
    TIMEOUT = "timeout"
    STOPPED = "stopped"
    INTERRUPTED = "interrupted"
    ERROR = "error"


@dataclass(frozen=True)
class RunResult:
    """The result of one run. None stands for a value that the backend cannot measure."""

    app: str
    """The app's name, or its file."""
    backend: str
    robot: str
    world: str | None
    """None if the backend has no world file."""
    seed: int | None
    outcome: Outcome
    exit_status: int
    """0 if the run is a success and the verification does not contradict it."""
    reason: str = ""
    """Why the run ended, as a sentence."""
    verified: bool | None = None
    """The simulator's judgement of `outcome`; None if it is unknown."""
    judge: str | None = None
    """The app that verified the run, if it is not the app itself."""
    sim_time_s: float = 0.0
    """The robot's time at the end, in seconds."""
    wall_time_s: float = 0.0
    ticks: int = 0
    overruns: int = 0
    """Ticks that took longer than their period."""
    contacts: int | None = None
    """Contacts of the robot with obstacles; None if the backend cannot count them."""
    distance_to_target_m: float | None = None
    interventions: int = 0
    """How often the command filter or the latch changed a command."""
    milestones: dict[str, float] = field(default_factory=dict)
    """The time of each milestone that was reached, in seconds."""
    conditions: dict[str, float | str] = field(default_factory=dict)
    """The values drawn from the seed (light, surfaces, sensors, wheels) and the values that the world's file fixes."""
    faults: list[str] = field(default_factory=list)
    """The specifications of the injected faults."""
    notes: list[str] = field(default_factory=list)
    """Warnings, and properties of the robot that differ from its description."""
    batteries: dict[str, dict[str, float]] = field(default_factory=dict)
    """For each battery the lowest and the last voltage: ``lowest_v``, ``last_v``."""
    trace_sha256: str | None = None
    """The digest of the trace, see `Trace`."""
    dropped_pictures: int | None = None
    """Pictures that the recording left out; None without a recording."""
    error: BaseException | None = field(default=None, repr=False, compare=False)
    """The exception that ended the run, if one did."""

    @property
    def verifier(self) -> str:
        """Whose word ``verified`` is."""
        return "judge" if self.judge else "simulator"

    @property
    def dispute(self) -> str:
        """Who does not agree with an app that says success, in words; empty where nobody disagrees."""
        if self.outcome is Outcome.SUCCESS and self.verified is False:
            return f"the {self.verifier} does not agree"
        return ""

    def to_json(self) -> str:
        """Return the result as one line of JSON, without the exception itself."""
        values = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "error"}
        return json.dumps(values)


class RunEnd(NamedTuple):
    """How a run ended: ``error`` ended it, if one did; ``late`` is what failed when it was over."""

    outcome: Outcome
    error: RobotcoreError | Interrupted | None
    late: RobotcoreError | None


def outcome_of(error: RobotcoreError | Interrupted) -> Outcome:
    """Return the outcome of a run that this ended."""
    if isinstance(error, Interrupted):
        return Outcome.INTERRUPTED
    return Outcome.STOPPED if isinstance(error, SafetyStop) else Outcome.ERROR


def build_result(
    plan: Plan, loop: Loop | None, verification: Verification, ending: RunEnd, wall_time: float
) -> RunResult:
    """Return all that is known of a run; ``loop`` is None where none began."""
    request, behaviour, (outcome, error, late) = plan.request, plan.behaviour, ending
    said = str(error) if error else behaviour.reason or _default_reason(outcome, request, behaviour)
    verified = False if error and verification.verified else verification.verified
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
        contacts=verification.contacts,
        distance_to_target_m=verification.distance,
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
