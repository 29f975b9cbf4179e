"""How a run ended, and what is told of it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, fields
from enum import Enum


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
