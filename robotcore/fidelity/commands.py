"""The commands of a recorded run to its wheels and servos, in the order of time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Wheels
from robotcore.recording import Tick
from robotcore.safety.velocity_limits import STOPPED

Array = NDArray[np.float64]


class WheelCommand(NamedTuple):
    """The velocities that the safety stage sent to the wheels, and the time from which they hold."""

    time: float
    """The time since the first tick, in seconds."""
    wheels: Wheels
    """The velocities in rad/s."""


class ServoCommand(NamedTuple):
    """An angle that was sent to a servo."""

    time: float
    """The time since the first tick, in seconds."""
    servo: str
    angle: float
    """The angle in radians."""


def list_wheel_commands(ticks: Sequence[Tick]) -> list[WheelCommand]:
    """Return the commands to the wheels, with the stops between two ticks, such as those of the deadman."""
    start = ticks[0].time if ticks else 0.0
    found = (WheelCommand(time - start, wheels) for tick in ticks for time, wheels in _list_commands(tick))
    return sorted(found, key=lambda command: command.time)  # stable: of two commands at a time, the later one holds


def _list_commands(tick: Tick) -> Iterator[tuple[float, Wheels]]:
    for each in tick.interventions:
        # A rule changes the command of its own tick. Any other stop comes before the tick, or in place of its command.
        if each.sent == STOPPED and (each.time < tick.time or tick.sent is None):
            yield each.time, STOPPED
    if tick.error or tick.commit_error:
        yield tick.time, STOPPED
    elif tick.sent:
        yield tick.time, tick.sent


def find_impossible_command(ticks: Sequence[Tick], limit_rad_s: float) -> Tick | None:
    """Return the first tick whose velocities no robot sends, since they are not finite or above a limit; else None.

    limit_rad_s: the greatest possible velocity of a wheel, in rad/s.
    """
    return next(
        (
            tick
            for tick in ticks
            if tick.sent
            and not (tick.error or tick.commit_error)
            and not all(abs(each) <= limit_rad_s for each in tick.sent)
        ),
        None,
    )


def list_servo_commands(ticks: Sequence[Tick], servos: frozenset[str]) -> list[ServoCommand]:
    """Return the angles that were sent to these servos."""
    return [
        ServoCommand(tick.time - ticks[0].time, each.device, float(each.given))
        for tick in ticks
        for each in tick.commands
        if each.device in servos and isinstance(each.given, (int, float)) and math.isfinite(each.given)
    ]


def integrate(commands: Sequence[WheelCommand], times: Array) -> Array:
    """Return the angles by which the commands have turned both wheels at these times, of shape (n, 2), in radians."""
    if not commands:
        return np.zeros((len(times), 2))
    starts = np.array([command.time for command in commands])
    velocities = np.array([command.wheels for command in commands])
    turned = np.cumsum(np.vstack((np.zeros(2), np.diff(starts)[:, None] * velocities[:-1])), axis=0)
    index = np.searchsorted(starts, times, side="right") - 1
    angles = turned[index] + (times - starts[index])[:, None] * velocities[index]
    return np.where(index[:, None] < 0, 0.0, angles)
