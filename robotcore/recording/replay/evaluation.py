"""Evaluate another app, or other settings, on the samples of a recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from robotcore.errors import Interrupted, RecordingEndedError
from robotcore.geometry import Wheels
from robotcore.hal.devices import Battery, SampleT, Sensor
from robotcore.recording import MotorCommand, Recording, Tick
from robotcore.recording.replay.app_permission import require_recorded_app
from robotcore.recording.replay.command_comparison import CommandComparator
from robotcore.recording.replay.cursor import TickReader, format_motor_command, format_wheels
from robotcore.recording.replay.verification import build_request, require_ticks
from robotcore.recording.tap import RecordingTap
from robotcore.runtime.apps import app_name
from robotcore.runtime.layers.base import MotorOutput, Reader, Tap
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Observer, Run, run
from robotcore.runtime.trace import TickRecord
from robotcore.safety import Latch


@dataclass(frozen=True)
class DecisionDifference:
    """The first tick in which the evaluated app decides differently from the recorded app."""

    tick: int
    time: float
    """The robot's time, in seconds."""
    subject: str
    """What differs, such as ``the command``."""
    recorded: str
    evaluated: str

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields of the ``parting`` key."""
        return {
            "tick": self.tick,
            "time": self.time,
            "what": self.subject,
            "recorded": self.recorded,
            "rehearsed": self.evaluated,
        }


@dataclass(frozen=True)
class Evaluation:
    """The result of an app that ran on the samples of a recording."""

    recording: Recording
    result: RunResult
    first_difference: DecisionDifference | None
    """The first decision that differs; None if all decisions are the same."""
    differing: int
    """The number of ticks with a different state or command."""
    late_reads: Mapping[str, int]
    """For each device, the number of ticks in which only the evaluated app read it, not the recorded run.

    The app then received the newest earlier sample, with the time of that sample.
    """
    states: Sequence[str]
    """The state of the app in each tick."""

    def __repr__(self) -> str:
        return f"<Evaluation of {self.result.app}: {self.differing} of {self.ticks} ticks differ>"

    @property
    def ticks(self) -> int:
        """The number of ticks that the app ran."""
        return len(self.states)

    @property
    def is_at_end(self) -> bool:
        """Whether the recording ended before the app did."""
        return isinstance(self.result.error, RecordingEndedError)

    @property
    def warning(self) -> str:
        """A text about the inputs of the run that the recording lacks; empty if it has all."""
        return self.recording.why_not

    @property
    def exit_status(self) -> int:
        """The exit status: 0 even if decisions differ, or the status of the app's error."""
        return self.result.exit_status if self.result.error and not self.is_at_end else 0

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        recorded = self.recording.result
        return {
            "app": self.result.app,
            "recorded_app": app_name(self.recording.metadata.request.app),
            "ticks": self.ticks,
            "recorded_ticks": len(self.recording.ticks),
            "differing_ticks": self.differing,
            "parting": self.first_difference and self.first_difference.to_dict(),
            "outcome": None if self.is_at_end else self.result.outcome.value,
            "recorded_outcome": recorded.outcome.value if recorded else None,
            "milestones": self.result.milestones,
            "recorded_milestones": recorded.milestones if recorded else None,
            "late_reads": dict(self.late_reads),
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
    observers: Sequence[Observer] = (),
) -> Evaluation:
    """Run an app on the samples of a recording, with a real command filter. A different decision is no error.

    app: the app; None for the recorded app.
    settings: new settings of the app. The recorded app also has its recorded values for all other settings.
    file: the name of the recording in error messages.
    observers: observers of the evaluation. They receive the run, each tick and the result.
    """
    require_ticks(recording, file)
    if app is None:
        require_recorded_app(recording, file, settings or {})
    request = build_request(recording)
    name = app or request.app
    kept = request.settings if app_name(name) == app_name(request.app) else {}
    comparator = DecisionComparator(recording)
    request = replace(request, app=name, settings={**kept, **(settings or {})})
    result = run(request, [comparator, *observers], [comparator])
    if result.error and not isinstance(result.error, Interrupted) and not result.ticks:
        raise result.error
    return comparator.build_evaluation(result)


class DecisionComparator(Tap):
    """A tap and an observer that compare the decisions of an app with the recorded ones.

    The odometry reads the recorded wheel angles, because the robot moved by the commands of the recorded app.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._is_equal = CommandComparator()
        self._current = TickReader(recording.ticks[0])
        self._recorder = RecordingTap(lambda: False)
        self._differing = 0
        self._first_difference: DecisionDifference | None = None
        self._late: Counter[str] = Counter()
        self._states: list[str] = []

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if isinstance(sensor, Battery):
            return read

        def reader() -> SampleT:
            self._late[sensor.name] += not self._current.was_read(sensor.name)
            return read()

        return reader

    def latch(self, latch: Latch) -> None:
        self._recorder.latch(latch)

    def standalone_motor(self, motor: MotorOutput) -> MotorOutput:
        return self._recorder.standalone_motor(motor)

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        def reader() -> Wheels:
            turned = self._current.next_angles()
            return turned.angles if turned and turned.angles else read()

        return reader

    def begin(self, run: Run) -> None:
        """Do nothing: the comparison begins with the first tick."""

    def tick(self, record: TickRecord) -> None:
        tick, motor_asks = self._current.tick, self._recorder.take().motor_asks
        self._states.append(record.state)
        if record.state != tick.state:
            self._report_difference(tick, "the state", repr(tick.state), repr(record.state))
        elif not self._is_equal(tick.asked, record.asked):
            self._report_difference(tick, "the command", _format_command(tick.asked), _format_command(record.asked))
        elif _format_motor_commands(tick.motor_asks) != _format_motor_commands(motor_asks):
            self._report_difference(
                tick, "the command", _format_motor_commands(tick.motor_asks), _format_motor_commands(motor_asks)
            )
        if len(self._states) < len(self._recording.ticks):
            self._current = TickReader(self._recording.ticks[len(self._states)])

    def end(self, result: RunResult) -> None:
        """Do nothing: `build_evaluation` takes the result."""

    def build_evaluation(self, result: RunResult) -> Evaluation:
        """Return the result of the evaluation."""
        late = {device: count for device, count in self._late.items() if count}
        return Evaluation(self._recording, result, self._first_difference, self._differing, late, self._states)

    def _report_difference(self, tick: Tick, subject: str, recorded: str, evaluated: str) -> None:
        self._differing += 1
        self._first_difference = self._first_difference or DecisionDifference(
            tick.number, tick.time, subject, recorded, evaluated
        )


def _format_motor_commands(asks: Iterable[MotorCommand]) -> str:
    return ", ".join(map(format_motor_command, asks)) or "no command"


def _format_command(asked: Wheels | None) -> str:
    return "no command" if asked is None else format_wheels(asked)
