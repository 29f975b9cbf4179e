"""What was decided, tick by tick, and its digest."""

from __future__ import annotations

import hashlib
import struct
from typing import NamedTuple

from robotcore.drive import Wheels
from robotcore.safety import Intervention

_COMMAND = struct.Struct("<dd")


class TickRecord(NamedTuple):
    """One tick: the state after it was decided, what was asked of the wheels and what was sent, rad/s.

    ``asked`` is None in a tick without a command, and so is ``sent``, unless the stage lessened one that lived on.
    ``lost`` names the device for whose loss the tick came to nothing.
    """

    tick: int
    time: float
    state: str
    asked: Wheels | None
    sent: Wheels | None
    interventions: tuple[Intervention, ...]
    lost: str | None = None


class Trace:
    """Adds up a run: digest, milestones, interventions.

    The digest is SHA-256 over, per tick, the state (UTF-8, ended by a zero byte), the number of commands asked
    for (one byte: 0 or 2) and the commands as little-endian doubles, left then right.
    """

    def __init__(self, milestones: tuple[str, ...]) -> None:
        self._awaited = set(milestones)
        self._hash = hashlib.sha256()
        self.ticks = 0
        self.interventions = 0
        self.milestones: dict[str, float] = {}

    def add(self, record: TickRecord) -> None:
        """Take one tick in."""
        self.ticks += 1
        self.interventions += len(record.interventions)
        state, asked = record.state, record.asked
        if state in self._awaited:
            self._awaited.discard(state)
            # no member of an app's own enumeration, nor what a sum of steps adds to a time
            self.milestones[str.__str__(state)] = round(record.time, 6)
        command = b"\0" if asked is None else b"\2" + _COMMAND.pack(*asked)
        self._hash.update(state.encode() + b"\0" + command)

    @property
    def sha256(self) -> str:
        return self._hash.hexdigest()
