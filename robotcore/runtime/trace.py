"""The record of each tick, and the digest of a run."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from robotcore.geometry import Wheels
from robotcore.hal.value_log import NOTHING_LOGGED, LoggedValue
from robotcore.safety.velocity_limits import Intervention

__all__ = ["MonitoredValue", "TickRecord", "Trace"]

_COMMAND = struct.Struct("<dd")


class MonitoredValue(NamedTuple):
    """The value of a sensor that the run reads by itself.

    >>> from robotcore.runtime.trace import MonitoredValue
    >>> str(MonitoredValue(7.412, "V"))
    '7.41 V'
    """

    value: float
    unit: str
    """The symbol of the unit, such as ``V``; empty for a number without a unit."""

    def __str__(self) -> str:
        return f"{self.value:.2f} {self.unit}".rstrip()


class TickRecord(NamedTuple):
    """The record of one tick.

    >>> from robotcore.testing import MockRobot
    >>> from apps.avoid_obstacles import AvoidObstacles
    >>> robot = MockRobot(range=1.0)
    >>> status = robot.run(AvoidObstacles(), ticks=2)
    >>> [(record.tick, record.time, record.asked == record.sent) for record in robot.ticks]
    [(0, 0.0, False), (1, 0.05, True)]
    """

    tick: int
    """The number of the tick, from 0."""
    time: float
    """The robot's time, in seconds."""
    state: str
    """The app's state at the end of the tick."""
    asked: Wheels | None
    """The app's command, in rad/s; None if it gave none."""
    sent: Wheels | None
    """The command that was sent, in rad/s; None if none was sent."""
    interventions: tuple[Intervention, ...]
    """The changes that the safety rules made to the command."""
    lost: str | None = None
    """The lost device for which the robot waits, so that the app was not called. None if no device is lost."""
    monitored: Mapping[str, MonitoredValue] = MappingProxyType({})
    """The last value of each sensor that the run reads by itself, by the sensor's name."""
    warnings: tuple[str, ...] = ()
    """The new warnings in this tick, each a sentence."""
    logged: Mapping[str, LoggedValue] = NOTHING_LOGGED
    """The values that the app logged in this tick, by name."""
    printed: tuple[str, ...] = ()
    """The lines that the app printed in this tick."""

    @property
    def status_text(self) -> str:
        """A text for displays: the app's state, or ``waiting for nose`` while the device ``nose`` is lost."""
        return f"waiting for {self.lost}" if self.lost else self.state


def format_monitored(values: Mapping[str, MonitoredValue]) -> str:
    """Return monitored values as a text. Each of several values has its sensor's name.

    >>> format_monitored({"cells": MonitoredValue(7.412, "V"), "engine": MonitoredValue(61.0, "°C")})
    'cells 7.41 V, engine 61.00 °C'
    """
    if len(values) == 1:
        return "".join(map(str, values.values()))
    return ", ".join(f"{name} {value}" for name, value in values.items())


class Trace:
    """The summary of a run's ticks: the digest, counts, milestones, warnings and voltages.

    The digest is the SHA-256 of these bytes of each tick: the app's state (UTF-8 and a zero byte), the number of wheel
    commands (one byte: 0 or 2), and the left and the right command (little-endian doubles).

    milestones: the names of the app's milestones.

    >>> from robotcore.geometry import Wheels
    >>> from robotcore.runtime.trace import TickRecord, Trace
    >>> trace = Trace(("seen",))
    >>> trace.add(TickRecord(0, 0.0, "search", Wheels(2.0, -2.0), Wheels(2.0, -2.0), ()))
    >>> trace.add(TickRecord(1, 0.05, "seen", None, None, ()))
    >>> trace
    Trace(ticks=2, interventions=0, milestones={'seen': 0.05})
    """

    def __init__(self, milestones: tuple[str, ...]) -> None:
        self._awaited = set(milestones)
        self._hash = hashlib.sha256()
        self.ticks = 0
        """The number of ticks."""
        self.interventions = 0
        """The number of interventions of safety rules."""
        self.milestones: dict[str, float] = {}
        """The time of each milestone that was reached, in seconds."""
        self.warnings: list[str] = []
        """The warnings of all ticks, in their order."""
        self.voltages: dict[str, dict[str, float]] = {}
        """For each sensor whose voltage the run monitors, the lowest and the last one: ``lowest_v``, ``last_v``."""
        self._monitored: Mapping[str, MonitoredValue] = {}

    def __repr__(self) -> str:
        return f"Trace(ticks={self.ticks}, interventions={self.interventions}, milestones={self.milestones})"

    def add(self, record: TickRecord) -> None:
        """Add the record of one tick."""
        self.ticks += 1
        self.interventions += len(record.interventions)
        self.warnings += record.warnings
        if record.monitored is not self._monitored:
            self._add_voltages(record.monitored)
        state, asked = record.state, record.asked
        if state in self._awaited:
            self._awaited.discard(state)
            # str: the state may be a member of an enumeration. round: a sum of steps has rounding errors
            self.milestones[str.__str__(state)] = round(record.time, 6)
        command = b"\0" if asked is None else b"\2" + _COMMAND.pack(*asked)
        self._hash.update(state.encode() + b"\0" + command)

    def _add_voltages(self, monitored: Mapping[str, MonitoredValue]) -> None:
        self._monitored = monitored
        for name, (voltage, unit) in monitored.items():
            if unit == "V":
                lowest = self.voltages.get(name, {}).get("lowest_v", voltage)
                self.voltages[name] = {"lowest_v": round(min(lowest, voltage), 3), "last_v": round(voltage, 3)}

    @property
    def sha256(self) -> str:
        """The digest as a hexadecimal text."""
        return self._hash.hexdigest()
