"""Encoder discs: a simulator's wheel angles become edges on pins."""

from __future__ import annotations

from abc import ABC, abstractmethod

from drivers.raspberrypi.virtual.pins import VirtualPin
from robotcore.hal.devices import Encoder

QUADRATURE = ((1, 1), (0, 1), (0, 0), (1, 0))
"""The levels of a and b, one edge after the other; forward, a leads."""


class Disc(ABC):
    """Turns with a wheel, and gives an edge each time that ``radians`` have passed."""

    def __init__(self, encoder: Encoder, radians: float) -> None:
        self._encoder, self._radians = encoder, radians
        self._at = 0

    def turn(self) -> None:
        """Give the edges that have passed since the last turn."""
        to = round(self._encoder.read().angle / self._radians)
        step = 1 if to > self._at else -1
        while self._at != to:
            self._at += step
            self._show(self._at)

    @abstractmethod
    def _show(self, edge: int) -> None:
        """Set the channels to what they are after so many edges; backward they are counted down."""


class QuadratureDisc(Disc):
    """Two channels, a quarter of a cycle apart: they tell the direction."""

    def __init__(self, encoder: Encoder, radians: float, a: VirtualPin, b: VirtualPin) -> None:
        super().__init__(encoder, radians)
        self._a, self._b = a, b
        self._show(0)

    def _show(self, edge: int) -> None:
        a, b = QUADRATURE[edge % len(QUADRATURE)]
        self._a.drive(a)
        self._b.drive(b)


class SlottedDisc(Disc):
    """One channel, which goes up and down whatever the direction."""

    def __init__(self, encoder: Encoder, radians: float, pin: VirtualPin) -> None:
        super().__init__(encoder, radians)
        self._pin = pin
        self._show(0)

    def _show(self, edge: int) -> None:
        self._pin.drive(edge % 2)
