"""The current tick of a replay, and the first difference between a replay and its recording."""

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
    """The time of the tick on the robot's clock, in seconds."""
    subject: str
    """The decision that differs, such as ``the command``."""
    recorded: str
    replayed: str
    reads: tuple[str, ...]
    """A text about each read of a sensor in the recorded tick."""

    @classmethod
    def of(
        cls, tick: Tick, subject: str, recorded: str, replayed: str, samples: Mapping[SampleKey, RecordedSample]
    ) -> Deviation:
        """Return a difference in a recorded tick, with texts about the reads of the tick."""
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
        """Yield the lines of a text about the difference."""
        yield f"tick {self.tick}, at {self.time:g} s, {self.subject} differs"
        yield f"  recorded: {self.recorded}"
        yield f"  replayed: {self.replayed}"
        yield f"  read in this tick: {'; '.join(self.reads) or 'nothing'}"


def format_wheels(wheels: Wheels | None) -> str:
    """Return a command to the drive as text with all digits; ``stop`` for None."""
    return "stop" if wheels is None else f"left {wheels.left!r}, right {wheels.right!r} rad/s"


def format_motor_command(ask: MotorCommand) -> str:
    """Return a command to a motor as text with all digits."""
    return f"{ask.device} stop" if ask.asked is None else f"{ask.device} {ask.asked!r} rad/s"


def _format_read(read: Read, samples: Mapping[SampleKey, RecordedSample]) -> str:
    if read.error:
        return f"{read.device} raised {read.error.kind}: {read.error.message}"
    return f"{read.device} {_format_sample(read, samples)} at {read.time:g} s, sequence {read.sequence}"


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
    """Returns the events of one recorded tick, one after the other."""

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
        """Whether a signal or the watchdog ended the run in this tick, so that its other events were not recorded."""
        is_signalled = self.tick.error is not None and self.tick.error.kind == Interrupted.__name__
        return is_signalled or any(each.cause == WatchdogError.cause for each in self.tick.interventions)

    @property
    def early_error(self) -> RobotcoreError | None:
        """The error of a latch that tripped before the first event of this tick, such as an e-stop; else None."""
        tick = self.tick
        has_begun = tick.reads or tick.asks or tick.motor_asks or tick.turned or not tick.interventions
        error = None if has_begun or tick.error is None else tick.error.rebuild()
        return error if isinstance(error, RobotcoreError) and not self.is_cut_short else None

    @property
    def emergency_stop(self) -> RobotcoreError | None:
        """The error of an e-stop that tripped before the command of this tick was sent; None if there is none."""
        error = self.tick.error.rebuild() if self.tick.error and not self.was_committed else None
        return error if isinstance(error, EmergencyStopError) else None

    @property
    def was_committed(self) -> bool:
        """Whether the run sent the command of this tick, so that an error of the tick occurred later."""
        return self.tick.asked is not None or self.tick.sent is not None

    def was_read(self, device: str) -> bool:
        """Return whether the recorded run read the device in this tick."""
        return device in self._devices

    def count_other_failures(self, device: str) -> int:
        """Take the app's next read of a device. Return how many reads by the guard or the odometry failed before it."""
        left, failed = self._reads[device], 0
        while left and left[0].by and left[0].error:
            left.popleft()
            failed += 1
        if left:
            left.popleft()
        return failed

    def next_command(self) -> DriveCommand | None:
        """Return the next recorded command to the drive; None after the last one."""
        return self.commands.popleft() if self.commands else None

    def next_angles(self) -> WheelAngles | None:
        """Return the next recorded wheel angles; after the last ones, these again. None if none were recorded."""
        return _take(self._angles)

    def next_held_command(self) -> Wheels:
        """Return the next recorded value of the drive's current command. After the last value, return it again."""
        return _take(self._held_commands) or STOPPED


def _take(left: deque[EventT]) -> EventT | None:
    if len(left) > 1:
        return left.popleft()
    return left[0] if left else None


class ReplayCursor:
    """The current tick of a replay, and the error that ended the replay.

    The app may catch this error. The next call of `raise_if_ended` raises it again.
    """

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.current = TickReader(recording.ticks[0])
        """The recorded tick that is compared with the current tick of the replay."""
        self.deviation: Deviation | None = None
        """The first difference; None if there is none so far."""
        self.trace = Trace(())
        """The trace of the equal ticks."""
        self._ended_by: RobotcoreError | None = None

    @property
    def equal_ticks(self) -> int:
        """The number of ticks that were equal to the recorded ones."""
        return self.trace.ticks

    @property
    def is_at_end(self) -> bool:
        """Whether the replay ended because the recording has no more events."""
        return isinstance(self._ended_by, RecordingEndedError)

    def raise_if_ended(self) -> None:
        """Raise the error that ended the replay, if there is one."""
        if self._ended_by:
            raise self._ended_by

    def report_difference(self, subject: str, recorded: str, replayed: str) -> NoReturn:
        """Store a difference and raise DeviationError, which ends the replay."""
        self.raise_if_ended()
        self.deviation = Deviation.of(self.current.tick, subject, recorded, replayed, self.recording.samples)
        self._end_with(DeviationError(str(self.deviation)))

    def report_missing(self, subject: str, recorded: str, replayed: str) -> NoReturn:
        """Report an event of the replay that was not recorded. If the recording ends in this tick, end the replay."""
        if self.current.is_cut_short:
            self.end()
        self.report_difference(subject, recorded, replayed)

    def end(self) -> NoReturn:
        """End the replay with RecordingEndedError, because the recording ends in this tick."""
        self.raise_if_ended()
        self._end_with(RecordingEndedError(self.equal_ticks, self.current.tick.time))

    def advance(self, record: TickRecord) -> None:
        """Add an equal tick to the trace, and continue with the next recorded tick."""
        self.trace.add(record)
        if self.equal_ticks < len(self.recording.ticks):
            self.current = TickReader(self.recording.ticks[self.equal_ticks])

    def _end_with(self, error: RobotcoreError) -> NoReturn:
        self._ended_by = error
        raise error
