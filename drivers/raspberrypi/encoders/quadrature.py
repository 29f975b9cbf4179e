"""An encoder with two channels, a quarter of a cycle apart: it tells the direction by itself."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import ClassVar

from drivers.raspberrypi.encoders.encoder import LEVELS, EncoderSettings, PinEncoder, open_input, watch
from drivers.raspberrypi.gpio import Gpio, gpio
from robotcore.description import EncoderDescription
from robotcore.hal.devices import Encoder
from robotcore.hardware import Connection, DeviceDriver, Host


class QuadratureSettings(EncoderSettings):
    """``a`` leads ``b`` where the wheel turns forward; where it counts the wrong way, swap the two."""

    edges_per_cycle: ClassVar[int] = 4

    a: Gpio
    b: Gpio


class Quadrature(DeviceDriver[EncoderDescription, QuadratureSettings]):
    """Counts all four edges of a cycle.

    gpiozero's RotaryEncoder is made for knobs with detents: it counts whole cycles, and loses one with each edge that
    it misses. A wheel that is to be controlled wants every edge, and no more lost than has to be.
    """

    name = "quadrature"
    summary = "a wheel's encoder with two channels on GPIOs"
    described = EncoderDescription
    settings = QuadratureSettings
    modules = ("gpiozero",)
    supply = ("3.3 V", "ground")
    remedy = "pip install 'robotcore[pi]'"

    def connections(self, settings: QuadratureSettings) -> Sequence[Connection]:
        return gpio("a", settings.a), gpio("b", settings.b)

    def notes(self, told: EncoderDescription, settings: QuadratureSettings) -> Sequence[str]:
        return (LEVELS,)

    def open(self, told: EncoderDescription, settings: QuadratureSettings, host: Host) -> Encoder:
        with ExitStack() as opened:
            a = open_input(told.name, settings.a, settings, host.pins, opened)
            b = open_input(told.name, settings.b, settings, host.pins, opened)
            decoder = QuadratureDecoder(a=bool(a.state), b=bool(b.state))
            watch(told.name, a, decoder.a_changed, opened)
            watch(told.name, b, decoder.b_changed, opened)
            return PinEncoder(told.name, host.clock, decoder, settings.edges_per_turn(told), opened.pop_all())


class QuadratureDecoder:
    """Counts the edges of two channels: up where ``a`` leads, down where ``b`` does.

    It goes by levels, not by edges: one that is missed costs as many as it hid, at most a cycle, and what comes
    after it counts as it should.

    >>> decoder = QuadratureDecoder(a=False, b=False)
    >>> decoder.a_changed(0.0, 1)
    >>> decoder.b_changed(0.1, 1)
    >>> decoder.edges
    2
    """

    def __init__(self, *, a: bool, b: bool) -> None:
        self.edges = 0
        self._phase = a << 1 | b

    def a_changed(self, _tick: float, level: int) -> None:
        """Take channel ``a``'s new level, 0 or 1."""
        self._turn(level << 1 | self._phase & 0b01)

    def b_changed(self, _tick: float, level: int) -> None:
        """Take channel ``b``'s new level, 0 or 1."""
        self._turn(self._phase & 0b10 | level)

    def _turn(self, phase: int) -> None:
        if phase != self._phase:
            self.edges += 1 if _NEXT[self._phase] == phase else -1
            self._phase = phase


_NEXT = (0b10, 0b00, 0b11, 0b01)
"""The phase that follows each, forward: (a, b) goes 00, 10, 11, 01."""
