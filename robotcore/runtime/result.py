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
    from robotcore.runtime.verification import Judgement


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
    """One run, told in full; None is what the backend cannot know.

    ``verified`` is the simulator's word on ``outcome``; ``judge`` is the app that was asked for it instead of this
    one. ``exit_status`` is 0 for a success that is not disputed. ``milestones`` maps each one reached to its time;
    ``conditions`` are what the seed drew of light, looks, sensors and wheels, by name, and what the world's file fixes
    of sensors and wheels; ``faults`` are the specs of what was to fail on purpose; ``notes`` say what of the robot was
    not what it seems, and what there was to warn of; ``batteries`` are the lowest voltage that each one told, and the
    last, ``lowest_v`` and ``last_v``, by name; ``dropped_pictures`` is how many its recording had to leave out, None
    where it was not recorded; ``error`` is what ended the run, if an error did.
    """

    app: str
    backend: str
    robot: str
    world: str | None
    seed: int | None
    outcome: Outcome
    exit_status: int
    reason: str = ""
    verified: bool | None = None
    judge: str | None = None
    sim_time_s: float = 0.0
    wall_time_s: float = 0.0
    ticks: int = 0
    overruns: int = 0
    contacts: int | None = None
    distance_to_target_m: float | None = None
    interventions: int = 0
    milestones: dict[str, float] = field(default_factory=dict)
    conditions: dict[str, float | str] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    batteries: dict[str, dict[str, float]] = field(default_factory=dict)
    trace_sha256: str | None = None
    dropped_pictures: int | None = None
    error: BaseException | None = field(default=None, repr=False, compare=False)

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
        told = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "error"}
        return json.dumps(told)


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
