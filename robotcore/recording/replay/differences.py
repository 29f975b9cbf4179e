"""Differences between the decisions of an app and the recorded ones."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass

from robotcore.errors import RecordingError
from robotcore.geometry import Wheels
from robotcore.hal.device import Sample, list_values
from robotcore.kinds.camera import Frame
from robotcore.recording.events import ActuatorCommand, DriveCommand, MotorCommand, Read, SampleKey, Tick
from robotcore.text import escape

NO_COMMAND = "no command"

PLATFORM_TOLERANCE = 1e-9
"""The tolerance in rad/s if the platform differs from the recorded one."""


@dataclass(frozen=True)
class Deviation:
    """The first decision of an app that differs from the recorded one.

    >>> print(Deviation(12, 0.6, "the command", "left 3.0, right 3.0 rad/s", "stop"))
    tick 12, at 0.6 s, the command differs
      recorded: left 3.0, right 3.0 rad/s
      replayed: stop
      read in this tick: nothing
    """

    tick: int
    """The number of the tick."""
    time: float
    """The time of the tick on the robot's clock, in seconds."""
    subject: str
    """The decision that differs, such as ``the command``."""
    recorded: str
    """The decision in the recording."""
    replayed: str
    """The decision in the replay."""
    reads: tuple[str, ...] = ()
    """A text about each read of a sensor in the recorded tick; empty for an evaluation."""

    def __str__(self) -> str:
        return "\n".join(map(escape, self.lines))

    @property
    def lines(self) -> list[str]:
        """The lines of a text about the difference."""
        return [
            f"tick {self.tick}, at {self.time:g} s, {self.subject} differs",
            f"  recorded: {self.recorded}",
            f"  replayed: {self.replayed}",
            f"  read in this tick: {'; '.join(self.reads) or 'nothing'}",
        ]


class CommandComparator:
    """Compares commands, with a ``tolerance`` in rad/s. With the tolerance 0, their bits must be equal.

    Two NaN are equal.
    """

    def __init__(self, tolerance: float = 0.0) -> None:
        self._tolerance = tolerance
        self.largest = 0.0
        """The largest difference within the tolerance so far, in rad/s."""
        self.is_exact = True
        """Whether all equal commands so far had equal bits."""

    def __call__(self, one: tuple[float, ...] | None, other: tuple[float, ...] | None) -> bool:
        """Return whether two commands are equal. A command has the velocity of each motor; None is a stop or none."""
        if one is None or other is None:
            return one is other
        if all(map(_is_same, one, other)):
            return True
        difference = max(map(_difference, one, other))
        is_alike = 0 < self._tolerance >= difference
        if is_alike:
            self.is_exact, self.largest = False, max(self.largest, difference)
        return is_alike


def _is_same(one: float, other: float) -> bool:
    return struct.pack("<d", one) == struct.pack("<d", other) or (math.isnan(one) and math.isnan(other))


def _difference(one: float, other: float) -> float:
    """Return the absolute difference of two numbers; infinity if only one is NaN, or if an infinite one differs."""
    if _is_same(one, other) or one == other:
        return 0.0
    return abs(one - other) if math.isfinite(one - other) else math.inf


def get_velocities(command: DriveCommand | MotorCommand) -> tuple[float, ...] | None:
    """Return the commanded velocity of each motor, in rad/s; None for a stop."""
    return (command.asked,) if isinstance(command.asked, (int, float)) else command.asked


def format_command(command: DriveCommand | MotorCommand | ActuatorCommand) -> str:
    """Return a command as text with all digits."""
    if isinstance(command, ActuatorCommand):
        return f"{command.device} {command.asked!r}"
    if isinstance(command, DriveCommand):
        return format_wheels(command.asked)
    return f"{command.device} stop" if command.asked is None else f"{command.device} {command.asked!r} rad/s"


def format_wheels(wheels: Wheels | None) -> str:
    """Return a command to the drive as text with all digits; ``stop`` for None."""
    return "stop" if wheels is None else f"left {wheels.left!r}, right {wheels.right!r} rad/s"


def format_reads(tick: Tick, samples: Mapping[SampleKey, Sample]) -> tuple[str, ...]:
    """Return a text about each read of a sensor in a tick."""
    return tuple(dict.fromkeys(_format_read(read, samples) for read in tick.reads))


def _format_read(read: Read, samples: Mapping[SampleKey, Sample]) -> str:
    if read.error:
        return f"{read.device} raised {read.error.kind}: {read.error.message}"
    try:
        sample = _format_sample(samples[read.key] if read.key else None)
    except RecordingError as error:
        sample = str(error)
    return f"{read.device} {sample} at {read.time:g} s, sequence {read.sequence}"


def _format_sample(sample: Sample | None) -> str:
    if sample is None:
        return "dropped picture"
    if isinstance(sample, Frame):
        height, width = sample.image.shape[:2]
        return f"{width} x {height} picture"
    values = ((getattr(sample, each.field), each) for each in list_values(type(sample)))
    named = [f"{value!r} {each.unit}".rstrip() for value, each in values]
    return ", ".join(named)
