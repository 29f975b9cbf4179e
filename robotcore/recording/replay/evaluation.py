"""Evaluate an app or other settings on the samples of a recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from robotcore.errors import RecordingEndedError
from robotcore.geometry import Wheels
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.hal.drive import WheelPath
from robotcore.recording import MotorCommand, Recording
from robotcore.recording.events import ActuatorCommand
from robotcore.recording.logged_summary import LoggedSeries
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay.app_permission import is_recorded_app, require_recorded_app
from robotcore.recording.replay.app_run import ReplayTap, require_ticks, run_app
from robotcore.recording.replay.differences import (
    NO_COMMAND,
    CommandComparator,
    Deviation,
    format_command,
    format_wheels,
)
from robotcore.recording.replay.verification import DIFFERS, explain_external_end
from robotcore.recording.tap import RecordingTap
from robotcore.runtime.apps import app_name
from robotcore.runtime.layers.base import MotorOutput, Reader, Send
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.safety.latch import Latch


@dataclass(frozen=True)
class Evaluation:
    """The result of an app on the samples of a recording.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> from robotcore.recording.replay import evaluate
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> evaluation = evaluate(recording, settings={"turn_rad_s": 0.5})
    >>> evaluation.first_difference.subject, evaluation.ticks, evaluation.exit_status
    ('the command', 11, 0)
    """

    recording: Recording
    result: RunResult
    first_difference: Deviation | None
    """The first decision that differs; None if all are equal."""
    differing: int
    """The number of ticks in which the state or the command differs."""
    late_reads: Mapping[str, int]
    """The number of ticks in which the app read a device that the recorded run did not read, by device name.

    In such a tick, the app receives the last recorded sample of the device.
    """
    states: Sequence[str]
    """The state of the evaluated app in each tick."""
    logged: Sequence[LoggedSeries] = ()
    """A summary of the values that the app logged, by name."""
    must_be_equal: bool = False
    """Whether a decision that differs has the exit status 1, as in a verification."""

    def __repr__(self) -> str:
        return f"<Evaluation of {self.result.app}: {self.differing} of {self.ticks} ticks differ>"

    @property
    def ticks(self) -> int:
        """The number of ticks of the evaluation."""
        return len(self.states)

    @property
    def is_at_end(self) -> bool:
        """Whether the recording ended before the evaluated app did."""
        return isinstance(self.result.error, RecordingEndedError)

    @property
    def warning(self) -> str:
        """Which inputs of the run are missing in the recording; empty if none is missing."""
        return self.recording.missing_inputs

    @property
    def is_equal(self) -> bool:
        """Whether all decisions, the devices that were read, and the end are those of the recorded run."""
        if self.differing or self.late_reads or self.ticks != len(self.recording.ticks):
            return False
        recorded = self.recording.result
        is_cut = not recorded or bool(explain_external_end(self.recording))
        return is_cut if self.is_at_end else recorded is not None and recorded.outcome is self.result.outcome

    @property
    def exit_status(self) -> int:
        """The exit status of the app's error. Without an error 1 if a decision differs and must not, else 0."""
        if self.result.error and not self.is_at_end:
            return self.result.exit_status
        return DIFFERS if self.must_be_equal and not self.is_equal else 0

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields.

        The JSON keys:

        app: text; the name of the app.
        recorded_app: text; the name of the recorded app.
        ticks: whole number; the number of ticks of the replay.
        recorded_ticks: whole number; the number of ticks of the recording.
        differing_ticks: whole number; the number of ticks in which the state or the command differs.
        parting: object or null; the first decision that differs. Null if there is none.
        parting.tick: whole number; the number of the tick.
        parting.time: number, s; the time of the tick on the robot's clock.
        parting.what: text; the decision that differs, such as ``the command``.
        parting.recorded: text; the decision in the recording.
        parting.rehearsed: text; the decision in the replay.
        outcome: text or null; how the app ended. Null if the recording ended before.
        recorded_outcome: text or null; how the recorded run ended. Null if the recording has no end.
        milestones: object of numbers, s; the time of each milestone in the replay.
        recorded_milestones: object of numbers, s, or null; the time of each milestone in the recorded run.
        late_reads: object of whole numbers; for each device the ticks in which only the replayed app read it.
        logged: list of objects; the values that the app logged in the replay.
        logged[].*: robotcore.recording.logged_summary.LoggedSeries.to_dict
        reason: text; why the app ended.
        warning: text or null; which inputs of the run are missing in the recording.
        exit_status: whole number; the exit status.
        """
        recorded, first = self.recording.result, self.first_difference
        return {
            "app": self.result.app,
            "recorded_app": app_name(self.recording.metadata.request.app_reference),
            "ticks": self.ticks,
            "recorded_ticks": len(self.recording.ticks),
            "differing_ticks": self.differing,
            "parting": first
            and {
                "tick": first.tick,
                "time": first.time,
                "what": first.subject,
                "recorded": first.recorded,
                "rehearsed": first.replayed,
            },
            "outcome": None if self.is_at_end else self.result.outcome.value,
            "recorded_outcome": recorded.outcome.value if recorded else None,
            "milestones": self.result.milestones,
            "recorded_milestones": recorded.milestones if recorded else None,
            "late_reads": dict(self.late_reads),
            "logged": [series.to_dict() for series in self.logged],
            "reason": self.result.reason,
            "warning": self.warning or None,
            "exit_status": self.exit_status,
        }


def evaluate(
    recording: Recording,
    app: str | None = None,
    settings: Mapping[str, Any] | None = None,
    *,
    file: Path | str = "",
    recorder: Recorder | None = None,
    must_be_equal: bool = False,
) -> Evaluation:
    """Run an app on the samples of a recording, and compare its decisions with the recorded ones.

    app: the name or the file of the app; None for the recorded app.
    settings: settings of the app by name. The recorded app has its recorded values for all others.
    file: the name of the recording in error messages.
    recorder: records the evaluation; None for no recording.
    must_be_equal: whether a decision that differs has the exit status 1.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> evaluate(recording)
    <Evaluation of avoid-obstacles: 0 of 11 ticks differ>
    >>> evaluate(recording, settings={"turn_rad_s": 0.5})
    <Evaluation of avoid-obstacles: 11 of 11 ticks differ>
    """
    require_ticks(recording, file)
    if app is None:
        require_recorded_app(recording, file, settings or {})
    recorded = recording.metadata.request
    comparator = DecisionComparator(recording)
    inherited = recorded.settings if app is None or is_recorded_app(recording, app) else {}
    result = run_app(comparator, app, {**inherited, **(settings or {})}, recorder)
    return replace(comparator.build_evaluation(result), must_be_equal=must_be_equal)


class DecisionComparator(ReplayTap):
    """Counts the ticks with another decision, and lets the run continue.

    The odometry receives the recorded wheel angles, so it computes the path of the recorded run.
    """

    def __init__(self, recording: Recording) -> None:
        super().__init__(recording)
        self._is_equal = CommandComparator()
        self._recorder = RecordingTap(lambda: False)
        self._differing = 0
        self._first_difference: Deviation | None = None
        self._late: Counter[str] = Counter()
        self._states: list[str] = []

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if sensor.is_monitored:
            return read

        def reader() -> SampleT:
            if not self.current.was_read(sensor.name):
                self._late[sensor.name] += 1
            return read()

        return reader

    def latch(self, latch: Latch) -> None:
        self._recorder.latch(latch)

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        return self._recorder.actuator(actuator, send)

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        return self._recorder.standalone_motor(motor)

    def wheel_path(self, read: Callable[[], WheelPath]) -> Callable[[], WheelPath]:
        def reader() -> WheelPath:
            turned = self.current.next_angles()
            return turned.path if turned and turned.path else read()

        return reader

    def tick(self, record: TickRecord) -> None:
        tick, events = self.current.tick, self._recorder.take()
        self._states.append(record.state)
        self.logged.add(record.logged)
        recorded, evaluated = (_format_commands([*each.motor_asks, *each.commands]) for each in (tick, events))
        if record.state != tick.state:
            self._add_difference("the state", repr(tick.state), repr(record.state))
        elif not self._is_equal(tick.asked, record.asked):
            self._add_difference("the command", *(_format_wheels(asked) for asked in (tick.asked, record.asked)))
        elif recorded != evaluated:
            self._add_difference("the command", recorded, evaluated)
        self.advance(len(self._states))

    def build_evaluation(self, result: RunResult) -> Evaluation:
        """Return the evaluation of a run with this result."""
        return Evaluation(
            self.recording,
            result,
            self._first_difference,
            self._differing,
            dict(self._late),
            self._states,
            self.logged.series,
        )

    def _add_difference(self, subject: str, recorded: str, evaluated: str) -> None:
        tick = self.current.tick
        self._differing += 1
        self._first_difference = self._first_difference or Deviation(
            tick.number, tick.time, subject, recorded, evaluated
        )


def _format_commands(commands: Iterable[MotorCommand | ActuatorCommand]) -> str:
    return ", ".join(map(format_command, commands)) or NO_COMMAND


def _format_wheels(asked: Wheels | None) -> str:
    return NO_COMMAND if asked is None else format_wheels(asked)
