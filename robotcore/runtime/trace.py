"""What was decided, tick by tick, and its digest."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from robotcore.geometry import Wheels
from robotcore.safety import Intervention

_COMMAND = struct.Struct("<dd")


class TickRecord(NamedTuple):
    """One tick: the state after it was decided, what was asked of the wheels and what was sent, rad/s.

    ``asked`` is None in a tick without a command, and so is ``sent``, unless the stage lessened one that lived on.
    ``lost`` names the device for whose loss the tick came to nothing.
    ``voltages`` are what the batteries told last, by name, in volts; ``warnings`` what is new in this tick and to be
    known, in whole sentences.
    """

    tick: int
    time: float
    state: str
    asked: Wheels | None
    sent: Wheels | None
    interventions: tuple[Intervention, ...]
    lost: str | None = None
    voltages: Mapping[str, float] = MappingProxyType({})
    warnings: tuple[str, ...] = ()

    @property
    def doing(self) -> str:
        """The app's state, or what the robot stands and waits for."""
        return f"waiting for {self.lost}" if self.lost else self.state


def format_voltages(voltages: Mapping[str, float]) -> str:
    """Return voltages in words; each with its battery's name only where there are several.

    >>> format_voltages({"battery": 7.412})
    '7.41 V'
    """
    if len(voltages) == 1:
        return "".join(f"{voltage:.2f} V" for voltage in voltages.values())
    return ", ".join(f"{name} {voltage:.2f} V" for name, voltage in voltages.items())


class Trace:
    """Adds up a run: digest, milestones, interventions, warnings, and what its batteries told, in volts.

    The digest is SHA-256 over, per tick, the state (UTF-8, ended by a zero byte), the number of commands asked
    for (one byte: 0 or 2) and the commands as little-endian doubles, left then right. No voltage is in it: what
    depends on one is in what was decided.
    """

    def __init__(self, milestones: tuple[str, ...]) -> None:
        self._awaited = set(milestones)
        self._hash = hashlib.sha256()
        self.ticks = 0
        self.interventions = 0
        self.milestones: dict[str, float] = {}
        self.warnings: list[str] = []
        self.batteries: dict[str, dict[str, float]] = {}
        self._voltages: Mapping[str, float] = {}

    def add(self, record: TickRecord) -> None:
        """Take one tick in."""
        self.ticks += 1
        self.interventions += len(record.interventions)
        self.warnings += record.warnings
        if record.voltages is not self._voltages:
            self._take_voltages(record.voltages)
        state, asked = record.state, record.asked
        if state in self._awaited:
            self._awaited.discard(state)
            # no member of an app's own enumeration, nor what a sum of steps adds to a time
            self.milestones[str.__str__(state)] = round(record.time, 6)
        command = b"\0" if asked is None else b"\2" + _COMMAND.pack(*asked)
        self._hash.update(state.encode() + b"\0" + command)

    def _take_voltages(self, voltages: Mapping[str, float]) -> None:
        self._voltages = voltages
        for battery, voltage in voltages.items():
            lowest = self.batteries.get(battery, {}).get("lowest_v", voltage)
            self.batteries[battery] = {"lowest_v": round(min(lowest, voltage), 3), "last_v": round(voltage, 3)}

    @property
    def sha256(self) -> str:
        return self._hash.hexdigest()
