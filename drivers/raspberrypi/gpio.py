"""The pins of the 40-pin header, by the numbers of the chip (BCM), as in ``gpiozero``."""

from __future__ import annotations

from typing import Annotated, NoReturn

from pydantic import AfterValidator, Field

from drivers.raspberrypi.header import HEADER
from drivers.raspberrypi.uart import lines_of
from robotcore.hardware import Connection


def _on_header(number: int) -> int:
    if number not in GPIOS:
        _refuse(number)
    return number


def _refuse(number: int | str) -> NoReturn:
    pad = next((f"; pad {number} of the header is {pad.name}" for pad in HEADER if pad.number == number), "")
    raise ValueError(f"there is no GPIO {number} on the header{pad}; take 0 to 27, the numbers of the chip (BCM)")


GPIOS = range(28)
"""Those on the header, the same on every board since the B+. Source: https://pinout.xyz."""

PULLED_UP = range(9)
"""Inputs with a pull-up, until a program drives them: the others have a pull-down.
Source: BCM2835 ARM Peripherals, 6.2, the column Pull; the same on a Pi 5."""

HELD_UP = (2, 3)
"""Of these, those with a resistor of 1.8 kΩ to 3.3 V on the board besides, for I²C."""

Gpio = Annotated[
    int, AfterValidator(_on_header), Field(description="the number of a GPIO on the header (BCM), 0 to 27")
]
"""A pin in a robot's file."""


def gpio(signal: str, number: int, *, is_shared: bool = False, instead: str = "") -> Connection:
    """Return the wire from a device's ``signal`` to a GPIO."""
    return Connection(signal, "GPIO", str(number), is_shared, instead)


def on_header(wire: Connection) -> tuple[Connection, ...]:
    """Return which pins a wire takes that is a serial port's.

    Raises ValueError, the fault, a semicolon and the remedy, for a wire to a GPIO that is none of the header's.
    """
    if wire.bus == "GPIO" and wire.where not in map(str, GPIOS):
        _refuse(int(wire.where) if wire.where.isdecimal() else wire.where)
    return lines_of(wire)
