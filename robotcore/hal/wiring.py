"""The wires between a robot's devices and a board's connector, for `robotcore wiring`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum


class PadKind(str, Enum):
    """The purpose of a pad on a connector."""

    SIGNAL = "signal"
    POWER = "power"
    GROUND = "ground"
    RESERVED = "reserved"


@dataclass(frozen=True)
class Pad:
    """A pad on a connector."""

    number: int
    """The pad's number on the connector."""
    name: str
    """The name of the pad's signal, such as ``GPIO 17``."""
    kind: PadKind


@dataclass(frozen=True)
class Wire:
    """A wire of a device."""

    device: str
    """The device's name."""
    what: str
    """The kind of the device, in a few words."""
    signal: str
    """The device's signal, such as ``trigger``."""
    where: str
    """A text that names the other end of the wire."""
    pads: tuple[int, ...] = ()
    """The numbers of the pads to which the wire can go, the best one first; empty without a connector."""


@dataclass(frozen=True)
class Wiring:
    """All wires of a robot."""

    pads: Sequence[Pad]
    """The pads of the connector in rows of two, arranged as on the board."""
    wires: Sequence[Wire]
    notes: Sequence[tuple[str, str]]
    """Further parts or settings that a device requires, each as the device's name and a sentence."""
