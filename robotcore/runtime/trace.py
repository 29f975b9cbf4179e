"""The record of each tick, and the digest of a run."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from robotcore.geometry import Wheels
from robotcore.safety.velocity_limits import Intervention

_COMMAND = struct.Struct("<dd")


class TickRecord(NamedTuple):
    """The record of one tick."""

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
    voltages: Mapping[str, float] = MappingProxyType({})
    """The last voltage of each battery, in volts, by name."""
    warnings: tuple[str, ...] = ()
    """The new warnings in this tick, each a sentence."""

    @property
    def status_text(self) -> str:
        """A text for displays: the app's state, or ``waiting for nose`` while the device ``nose`` is lost."""
        return f"waiting for {self.lost}" if self.lost else self.state


def format_voltages(voltages: Mapping[str, float]) -> str:
    """Return voltages as a text. Each of several voltages has its battery's name.

    >>> format_voltages({"battery": 7.412})
    '7.41 V'
    """
    if len(voltages) == 1:
        return "".join(f"{voltage:.2f} V" for voltage in voltages.values())
    return ", ".join(f"{name} {voltage:.2f} V" for name, voltage in voltages.items())


class Trace:
    """The summary of a run's ticks: the digest, counts, milestones, warnings and voltages.

    The digest is the SHA-256 of these bytes of each tick: the app's state (UTF-8 and a zero byte), the number of wheel
    commands (one byte: 0 or 2), and the left and the right command (little-endian doubles).

    milestones: the names of the app's milestones.

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
        self.interventions = 0
        self.milestones: dict[str, float] = {}
        """The time of each milestone that was reached, in seconds."""
        self.warnings: list[str] = []
        self.batteries: dict[str, dict[str, float]] = {}
        """For each battery the lowest and the last voltage: ``lowest_v``, ``last_v``."""
        self._voltages: Mapping[str, float] = {}

    def __repr__(self) -> str:
        return f"Trace(ticks={self.ticks}, interventions={self.interventions}, milestones={self.milestones})"

    def add(self, record: TickRecord) -> None:
        """Add the record of one tick."""
        self.ticks += 1
        self.interventions += len(record.interventions)
        self.warnings += record.warnings
        if record.voltages is not self._voltages:
            self._add_voltages(record.voltages)
        state, asked = record.state, record.asked
        if state in self._awaited:
            self._awaited.discard(state)
            # str: the state may be a member of an enumeration. round: a sum of steps has rounding errors
            self.milestones[str.__str__(state)] = round(record.time, 6)
        command = b"\0" if asked is None else b"\2" + _COMMAND.pack(*asked)
        self._hash.update(state.encode() + b"\0" + command)

    def _add_voltages(self, voltages: Mapping[str, float]) -> None:
        self._voltages = voltages
        for battery, voltage in voltages.items():
            lowest = self.batteries.get(battery, {}).get("lowest_v", voltage)
            self.batteries[battery] = {"lowest_v": round(min(lowest, voltage), 3), "last_v": round(voltage, 3)}

    @property
    def sha256(self) -> str:
        """The digest as a hexadecimal text."""
        return self._hash.hexdigest()
