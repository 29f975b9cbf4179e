"""Evaluate an app or other settings on the samples of a recording."""

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
    """The first decision of the evaluated app that differs from the recorded decision."""

    tick: int
    time: float
    """The time of the tick on the robot's clock, in seconds."""
    subject: str
    """The decision: ``the state`` or ``the command``."""
    recorded: str
    evaluated: str

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        return {
            "tick": self.tick,
            "time": self.time,
            "what": self.subject,
            "recorded": self.recorded,
            "rehearsed": self.evaluated,
        }


@dataclass(frozen=True)
class Evaluation:
    """The result of an app on the samples of a recording."""

    recording: Recording
    result: RunResult
    first_difference: DecisionDifference | None
    """The first decision that differs; None if all are equal."""
    differing: int
    """The number of ticks in which the state or the command differs."""
    late_reads: Mapping[str, int]
    """The number of ticks in which the app read a device that the recorded run did not read, by device name.

    In such a tick, the app receives the last recorded sample of the device.
    """
    states: Sequence[str]
    """The state of the evaluated app in each tick."""

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
    def exit_status(self) -> int:
        """The exit status of the app's error; without an error 0, even if decisions differ."""
        return self.result.exit_status if self.result.error and not self.is_at_end else 0

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        recorded = self.recording.result
        return {
            "app": self.result.app,
            "recorded_app": app_name(self.recording.metadata.request.app_reference),
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
    """Run an app on the samples of a recording, and compare its decisions with the recorded ones.

    app: the name or the file of the app; None for the recorded app.
    settings: settings of the app by name. The recorded app has its recorded values for all others.
    file: the name of the recording in error messages.
    observers: observers of the evaluation run.
    """
    require_ticks(recording, file)
    if app is None:
        require_recorded_app(recording, file, settings or {})
    request = build_request(recording)
    name = app or request.app_reference
    kept = request.settings if app_name(name) == app_name(request.app_reference) else {}
    comparator = DecisionComparator(recording)
    request = replace(request, app=name, settings={**kept, **(settings or {})})
    result = run(request, [comparator, *observers], [comparator])
    if result.error and not isinstance(result.error, Interrupted) and not result.ticks:
        raise result.error
    return comparator.build_evaluation(result)


class DecisionComparator(Tap):
    """A tap and an observer that compare the decisions of an app with the recorded ones.

    The odometry receives the recorded wheel angles, so it computes the path of the recorded run.
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
        """Do nothing. The comparison begins with the first tick."""

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
        """Do nothing. `build_evaluation` receives the result."""

    def build_evaluation(self, result: RunResult) -> Evaluation:
        """Return the evaluation of a run with this result."""
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
