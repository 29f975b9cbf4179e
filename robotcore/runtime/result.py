"""The result of a run: its outcome and the measured values."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, fields
from enum import Enum

from robotcore.errors import Interrupted, RobotcoreError, RoutineError, SafetyStop
from robotcore.text import pluralize

__all__ = ["Outcome", "RunResult"]


class Outcome(str, Enum):
    """How a run ended, before its verification.

    >>> from robotcore import RunResult
    >>> result = RunResult("green-search", "kinematic", "rover", "arena", 7, Outcome.TIMEOUT, exit_status=1)
    >>> result.outcome is Outcome.TIMEOUT, result.outcome.value
    (True, 'timeout')
    """

    SUCCESS = "success"
    """The app returned `Status.SUCCESS`."""
    FAILURE = "failure"
    """The app returned `Status.FAILURE`, or one of its routines did not reach its end."""
    TIMEOUT = "timeout"
    """The app did not end within the run's time limit."""
    STOPPED = "stopped"
    """A safety rule, the watchdog or the e-stop ended the run."""
    INTERRUPTED = "interrupted"
    """A signal ended the run."""
    ERROR = "error"
    """The app raised an exception, or a device or the backend failed."""


class WrittenNote(str):
    """A note that the run has already written on stderr."""

    __slots__ = ()


class RealTimeNote(WrittenNote):
    """A note about the real-time priority of the run and its locked memory."""

    __slots__ = ()


@dataclass(frozen=True)
class RunResult:
    """The result of one run. A value that the backend cannot measure is None.

    >>> from robotcore import Outcome, RunRequest, run
    >>> result = run(RunRequest("avoid-obstacles", settings={"duration_s": 1.0}))
    >>> result
    RunResult(avoid-obstacles on kinematic: success, 21 ticks, 1.0 s)
    >>> result.outcome is Outcome.SUCCESS, result.exit_status, result.contacts
    (True, 0, 0)
    >>> result.sim_time_s, result.error is None
    (1.0, True)
    """

    app: str
    """The app's name, or its file."""
    backend: str
    """The backend's name."""
    robot: str
    """The robot's name."""
    world: str | None
    """The name of the world. None if the run has none."""
    seed: int | None
    """The seed of the request. None if it has none."""
    outcome: Outcome
    """How the run ended by the app's own account, or by an error."""
    exit_status: int
    """The exit status of the program. It is 0 if the app succeeded and ``verified`` is not False."""
    reason: str = ""
    """Why the run ended, as a sentence."""
    verified: bool | None = None
    """Whether the simulator's true state confirms a success. None without true poses, and without a ``verify``."""
    judge: str | None = None
    """The app that verified the run, if it is not the app itself."""
    sim_time_s: float = 0.0
    """The robot's time at the end, in seconds."""
    wall_time_s: float = 0.0
    """The duration of the run in real time, with the opening and closing of the robot, in seconds."""
    ticks: int = 0
    """The number of ticks."""
    overruns: int = 0
    """The number of ticks that took longer than their period."""
    tick_times_us: dict[str, dict[str, float]] = field(default_factory=dict)
    """For each phase of a tick its durations in microseconds: ``p50``, ``p99``, ``worst``. See `TickStatistics`."""
    contacts: int | None = None
    """The number of the robot's contacts with obstacles. None if the backend cannot count them."""
    distance_to_target_m: float | None = None
    """The distance at the end from the front of the robot's body to the target's surface, in metres."""
    interventions: int = 0
    """The number of times that the safety stage changed a command, see the page "Safety"."""
    intervention_s: dict[str, float] = field(default_factory=dict)
    """For each cause of interventions the time for which the changed commands lasted, in seconds."""
    milestones: dict[str, float] = field(default_factory=dict)
    """The time of each milestone that was reached, in seconds."""
    conditions: dict[str, float | str] = field(default_factory=dict)
    """The values drawn from the seed (light, surfaces, sensors, wheels) and the values that the world's file fixes."""
    faults: list[str] = field(default_factory=list)
    """The specifications of the injected faults."""
    notes: list[str] = field(default_factory=list)
    """Warnings, and properties of the robot that differ from its description."""
    batteries: dict[str, dict[str, float]] = field(default_factory=dict)
    """For each battery the lowest and the last voltage in volts: ``lowest_v``, ``last_v``."""
    trace_sha256: str | None = None
    """The digest of the trace, see `Trace`."""
    dropped_pictures: int | None = None
    """The number of pictures that are missing in the recording. None without a recording."""
    ideal: bool = False
    """Whether the simulated devices had none of the imperfections of the robot's file."""
    error: BaseException | None = field(default=None, repr=False, compare=False)
    """The exception that ended the run, if one did."""

    def __repr__(self) -> str:
        reason = f", {self.reason!r}" if self.reason else ""
        time = f"{self.ticks} ticks, {self.sim_time_s} s"
        return f"RunResult({self.app} on {self.backend}: {self.headline}, {time}{reason})"

    @property
    def verifier(self) -> str:
        """The source of ``verified``: ``judge`` if another app verified the run, otherwise ``simulator``."""
        return "judge" if self.judge else "simulator"

    @property
    def dispute(self) -> str:
        """A clause if the app reports a success and the verification does not. Otherwise an empty text."""
        if self.outcome is Outcome.SUCCESS and self.verified is False:
            return f"not confirmed by the {self.verifier}"
        return ""

    @property
    def outcome_text(self) -> str:
        """The outcome as text; ``disputed`` if the app reports a success and the verification does not."""
        return "disputed" if self.dispute else self.outcome.value

    @property
    def headline(self) -> str:
        """The outcome as text, and the contacts if there are any, such as ``success, 2 contacts``."""
        return f"{self.outcome_text}, {pluralize(self.contacts, 'contact')}" if self.contacts else self.outcome_text

    def to_json(self) -> str:
        """Return the result as one line of JSON, without ``error``."""
        values = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "error"}
        return json.dumps(values)


def get_outcome(error: RobotcoreError | Interrupted) -> Outcome:
    """Return the outcome of a run that ended with an error."""
    if isinstance(error, Interrupted):
        return Outcome.INTERRUPTED
    if isinstance(error, RoutineError):
        return Outcome.FAILURE
    return Outcome.STOPPED if isinstance(error, SafetyStop) else Outcome.ERROR
