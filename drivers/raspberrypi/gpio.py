"""The pins of the 40-pin header, by the numbers of the chip (BCM), as in ``gpiozero``."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from robotcore.hardware import Connection

Gpio = Annotated[int, Field(ge=0, le=27, description="the number of a GPIO on the header (BCM), 0 to 27")]
"""A pin in a robot's file. Source: https://pinout.xyz, the same on every board since the B+."""


def gpio(signal: str, number: int, *, is_shared: bool = False) -> Connection:
    """Return the wire from a device's ``signal`` to a GPIO."""
    return Connection(signal, "GPIO", str(number), is_shared)
