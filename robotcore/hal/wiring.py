"""The wires between a robot's devices and a board's connector, for `robotcore wiring`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum


class PadKind(str, Enum):
    """The purpose of a pad of a board's connector.

    >>> PadKind("ground") is PadKind.GROUND
    True
    """

    SIGNAL = "signal"
    POWER = "power"
    GROUND = "ground"
    RESERVED = "reserved"


@dataclass(frozen=True)
class Pad:
    """A pad of a board's connector.

    >>> from robotcore.hardware import PadKind
    >>> Pad(number=11, name="GPIO 17", kind=PadKind.SIGNAL).name
    'GPIO 17'
    """

    number: int
    """The number of the pad on the connector, from 1 on."""
    name: str
    """The signal of the pad, such as ``GPIO 17``."""
    kind: PadKind
    """The use of the pad."""


@dataclass(frozen=True)
class Wire:
    """A wire between a device and a board.

    >>> Wire("nose", "range sensor, hc-sr04", "trigger", "GPIO 16", pads=(36,)).where
    'GPIO 16'
    """

    device: str
    """The device's name."""
    what: str
    """The kind of the device, in a few words."""
    signal: str
    """The name of the wire at the device, such as ``trigger``."""
    where: str
    """The name of the wire's end at the board, such as ``GPIO 17``."""
    pads: tuple[int, ...] = ()
    """The numbers of the suitable pads, the best one first; empty if the wire goes to no connector."""


@dataclass(frozen=True)
class Wiring:
    """All wires between a robot's devices and its board.

    >>> from robotcore.hardware import Pad, PadKind, Wire
    >>> pads = [Pad(1, "3.3 V", PadKind.POWER), Pad(2, "5 V", PadKind.POWER)]
    >>> wiring = Wiring(pads, [Wire("nose", "range sensor, hc-sr04", "supply", "5 V", pads=(2,))], notes=[])
    >>> [(wire.device, wire.signal, wire.where) for wire in wiring.wires]
    [('nose', 'supply', '5 V')]
    """

    pads: Sequence[Pad]
    """The pads of the connector, row by row. Each row has two pads."""
    wires: Sequence[Wire]
    notes: Sequence[tuple[str, str]]
    """The notes about further parts or settings, each as a device's name and a sentence."""
