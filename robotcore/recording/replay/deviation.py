"""The first thing that a replay does otherwise than its recording, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from robotcore.errors import RecordingError
from robotcore.geometry import Wheels
from robotcore.hal.devices import Angle, Frame, Range, Voltage
from robotcore.recording import MotorAsk, Read, Recorded, SampleKey, Tick
from robotcore.text import escape


@dataclass(frozen=True)
class Deviation:
    """What differs, in which tick, and what was read in it; ``time`` in seconds on the robot's clock."""

    tick: int
    time: float
    what: str
    recorded: str
    replayed: str
    reads: tuple[str, ...]

    @classmethod
    def of(
        cls, tick: Tick, what: str, recorded: str, replayed: str, samples: Mapping[SampleKey, Recorded]
    ) -> Deviation:
        """Return what differs in a tick, told with the samples that the recorded run read in it."""
        reads = dict.fromkeys(_read_told(read, samples) for read in tick.reads)
        return cls(tick.number, tick.time, what, recorded, replayed, tuple(reads))

    def __str__(self) -> str:
        return "\n".join(map(escape, self.lines()))

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON tells of it."""
        told = asdict(self)
        told["time_s"] = told.pop("time")
        return told

    def lines(self) -> Iterator[str]:
        """Yield it in words, a fact each."""
        yield f"tick {self.tick}, at {self.time:g} s, {self.what} differs"
        yield f"  recorded: {self.recorded}"
        yield f"  replayed: {self.replayed}"
        yield f"  read in this tick: {'; '.join(self.reads) or 'nothing'}"


def wheels_told(wheels: Wheels | None) -> str:
    """Return a command with every digit that it has; None is a stop."""
    return "stop" if wheels is None else f"left {wheels.left!r}, right {wheels.right!r} rad/s"


def motor_told(ask: MotorAsk) -> str:
    """Return a command to a motor outside the drive, with every digit that it has."""
    return f"{ask.device} stop" if ask.asked is None else f"{ask.device} {ask.asked!r} rad/s"


def _read_told(read: Read, samples: Mapping[SampleKey, Recorded]) -> str:
    if read.error:
        return f"{read.device} raised {read.error.kind}: {read.error.message}"
    return f"{read.device} {_sample_told(read, samples)} of {read.time:g} s (number {read.sequence})"


def _sample_told(read: Read, samples: Mapping[SampleKey, Recorded]) -> str:
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
