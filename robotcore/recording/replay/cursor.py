"""The current tick of a replay in its recording, and the first difference between both."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any, NoReturn, TypeVar

from robotcore.errors import (
    DeviationError,
    EmergencyStopError,
    Interrupted,
    RecordingEndedError,
    RecordingError,
    RobotcoreError,
    WatchdogError,
)
from robotcore.geometry import Wheels
from robotcore.hal.devices import Angle, Frame, Range, Voltage
from robotcore.recording import (
    DriveCommand,
    MotorCommand,
    Read,
    RecordedSample,
    Recording,
    SampleKey,
    Tick,
    WheelAngles,
)
from robotcore.runtime.trace import TickRecord, Trace
from robotcore.safety.velocity_limits import STOPPED
from robotcore.text import escape


@dataclass(frozen=True)
class Deviation:
    """The first difference between a replay and its recording."""

    tick: int
    time: float
    """The robot's time, in seconds."""
    subject: str
    """What differs, such as ``the command``."""
    recorded: str
    replayed: str
    reads: tuple[str, ...]
    """Texts about the sensor reads of the recorded run in this tick."""

    @classmethod
    def of(
        cls, tick: Tick, subject: str, recorded: str, replayed: str, samples: Mapping[SampleKey, RecordedSample]
    ) -> Deviation:
        """Return a difference in a tick, with texts about the samples that the recorded run read in this tick."""
        reads = dict.fromkeys(_format_read(read, samples) for read in tick.reads)
        return cls(tick.number, tick.time, subject, recorded, replayed, tuple(reads))

    def __str__(self) -> str:
        return "\n".join(map(escape, self.lines()))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        payload = asdict(self)
        payload["time_s"] = payload.pop("time")
        return payload

    def lines(self) -> Iterator[str]:
        """Yield the lines of a message about the difference, one fact in each line."""
        yield f"tick {self.tick}, at {self.time:g} s, {self.subject} differs"
        yield f"  recorded: {self.recorded}"
        yield f"  replayed: {self.replayed}"
        yield f"  read in this tick: {'; '.join(self.reads) or 'nothing'}"


def format_wheels(wheels: Wheels | None) -> str:
    """Return the text of a drive command with all digits; ``stop`` for None."""
    return "stop" if wheels is None else f"left {wheels.left!r}, right {wheels.right!r} rad/s"


def format_motor_command(ask: MotorCommand) -> str:
    """Return the text of a motor command with all digits."""
    return f"{ask.device} stop" if ask.asked is None else f"{ask.device} {ask.asked!r} rad/s"


def _format_read(read: Read, samples: Mapping[SampleKey, RecordedSample]) -> str:
    if read.error:
        return f"{read.device} raised {read.error.kind}: {read.error.message}"
    return f"{read.device} {_format_sample(read, samples)} of {read.time:g} s (number {read.sequence})"


def _format_sample(read: Read, samples: Mapping[SampleKey, RecordedSample]) -> str:
    try:
        sample = samples[read.key] if read.key else None
    except RecordingError as error:
        return str(error)
    match sample:
        case Range():
            return f"{sample.distance!r} m"
        case Angle():
            return f"{sample.angle!r} rad"
        case Voltage():
            return f"{sample.voltage!r} V"
        case Frame():
            height, width = sample.image.shape[:2]
            return f"{width} x {height} picture"
    return "dropped picture"


EventT = TypeVar("EventT")


class TickReader:
    """Returns the events of one recorded tick in their order.

    If the replay reads more wheel angles or current drive commands than were recorded, it gets the last one again.
    """

    def __init__(self, tick: Tick) -> None:
        self.tick = tick
        self.commands = deque(tick.asks)
        self._angles, self._held_commands = deque(tick.turned), deque(tick.standing)
        self.motor_commands = deque(tick.motor_asks)
        self._reads: dict[str, deque[Read]] = defaultdict(deque)
        for read in tick.reads:
            self._reads[read.device].append(read)
        self._devices = frozenset(self._reads)

    @property
    def is_cut_short(self) -> bool:
        """Whether a signal or a watchdog ended the run in this tick, so that the rest of the tick is unknown."""
        is_signalled = self.tick.error is not None and self.tick.error.kind == Interrupted.__name__
        return is_signalled or any(each.cause == WatchdogError.cause for each in self.tick.interventions)

    @property
    def early_error(self) -> RobotcoreError | None:
        """The error that tripped the latch before this tick began, such as an e-stop; None if there is none."""
        tick = self.tick
        has_begun = tick.reads or tick.asks or tick.motor_asks or tick.turned or not tick.interventions
        error = None if has_begun or tick.error is None else tick.error.rebuild()
        return error if isinstance(error, RobotcoreError) and not self.is_cut_short else None

    @property
    def emergency_stop(self) -> RobotcoreError | None:
        """The e-stop that tripped within this tick. The recorded answers of the drive show at which command."""
        error = self.tick.error.rebuild() if self.tick.error and not self.was_committed else None
        return error if isinstance(error, EmergencyStopError) else None

    @property
    def was_committed(self) -> bool:
        """Whether the run sent a command at the end of this tick. An error of the tick then came after the command."""
        return self.tick.asked is not None or self.tick.sent is not None

    def was_read(self, device: str) -> bool:
        """Return whether the recorded run read the device in this tick."""
        return device in self._devices

    def count_other_failures(self, device: str) -> int:
        """Return how often reads by the range guard or the odometry failed before the app's next read of the device."""
        left, failed = self._reads[device], 0
        while left and left[0].by and left[0].error:
            left.popleft()
            failed += 1
        if left:
            left.popleft()
        return failed

    def next_command(self) -> DriveCommand | None:
        """Return the next recorded drive command; None if all have been returned."""
        return self.commands.popleft() if self.commands else None

    def next_angles(self) -> WheelAngles | None:
        """Return the recorded wheel angles; None if the run had no drive."""
        return _take(self._angles)

    def next_held_command(self) -> Wheels:
        """Return the next recorded value of the drive's current command. An app reads it to command a single wheel."""
        return _take(self._held_commands) or STOPPED


def _take(left: deque[EventT]) -> EventT | None:
    if len(left) > 1:
        return left.popleft()
    return left[0] if left else None


class ReplayCursor:
    """The current tick of a replay in its recording.

    After the replay has ended, each call of `raise_if_ended` raises the same error. An app cannot suppress the error.
    """

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.current = TickReader(recording.ticks[0])
        """The recorded tick with which the replay is compared."""
        self.deviation: Deviation | None = None
        """The first difference; None if there is none so far."""
        self.trace = Trace(())
        """The trace of the ticks that are equal to the recorded ones."""
        self._ended_by: RobotcoreError | None = None

    @property
    def equal_ticks(self) -> int:
        """The number of ticks so far that are equal to the recorded ones."""
        return self.trace.ticks

    @property
    def is_at_end(self) -> bool:
        """Whether the recording ended within this tick, so that the app's next input or answer is missing."""
        return isinstance(self._ended_by, RecordingEndedError)

    def raise_if_ended(self) -> None:
        """Raise the error that ended the replay, if there is one."""
        if self._ended_by:
            raise self._ended_by

    def report_difference(self, subject: str, recorded: str, replayed: str) -> NoReturn:
        """Store the first difference, and raise DeviationError."""
        self.raise_if_ended()
        self.deviation = Deviation.of(self.current.tick, subject, recorded, replayed, self.recording.samples)
        self._end_with(DeviationError(str(self.deviation)))

    def report_missing(self, subject: str, recorded: str, replayed: str) -> NoReturn:
        """Report an event that the recording lacks. If the recording ended within this tick, end the replay."""
        if self.current.is_cut_short:
            self.end()
        self.report_difference(subject, recorded, replayed)

    def end(self) -> NoReturn:
        """Raise RecordingEndedError, because the recording ended within this tick."""
        self.raise_if_ended()
        self._end_with(RecordingEndedError(self.equal_ticks, self.current.tick.time))

    def advance(self, record: TickRecord) -> None:
        """Count this tick as equal, and continue with the next recorded tick."""
        self.trace.add(record)
        if self.equal_ticks < len(self.recording.ticks):
            self.current = TickReader(self.recording.ticks[self.equal_ticks])

    def _end_with(self, error: RobotcoreError) -> NoReturn:
        self._ended_by = error
        raise error
