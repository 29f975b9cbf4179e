"""A robot's wires, to be drawn: which device's signal goes to which pad of a connector."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum


class PadKind(str, Enum):
    """What a pad of a connector is for."""

    SIGNAL = "signal"
    POWER = "power"
    GROUND = "ground"
    RESERVED = "reserved"


@dataclass(frozen=True)
class Pad:
    """One pad of a connector, by the number that it has there; ``name`` is what it carries, such as ``GPIO 17``."""

    number: int
    name: str
    kind: PadKind


@dataclass(frozen=True)
class Wire:
    """One wire of a device: its signal, and where it goes.

    ``what`` says what the device is; ``pads`` are those of the connector to which the wire can go, the best one first,
    none where it goes elsewhere.
    """

    device: str
    what: str
    signal: str
    where: str
    pads: tuple[int, ...] = ()


@dataclass(frozen=True)
class Wiring:
    """All wires of a robot; ``pads`` are the connector's, in rows of two, as they lie on the board.

    ``notes`` say what else belongs to a device, by its name.
    """

    pads: Sequence[Pad]
    wires: Sequence[Wire]
    notes: Sequence[tuple[str, str]]
