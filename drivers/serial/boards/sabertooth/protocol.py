"""Sabertooth packet serial: frames of four bytes that nobody answers.

Source: Dimension Engineering's manuals of the Sabertooth 2x5, 2x12 and 2x25, mode 4, packetized serial.
"""

from __future__ import annotations

import math
from typing import Literal

MotorNumber = Literal[1, 2]
"""M1 or M2, as the board has them."""

BAUDING = b"\xaa"
"""Sent before all else: the board takes its baud rate from it. One that has a rate already does nothing about it."""

LOWEST_ADDRESS, HIGHEST_ADDRESS = 128, 135
"""The addresses that the board's switches can set."""

MOST = 127
"""A whole duty."""

MOST_TIMEOUT_S = 12.7

_TIMEOUT = 14


def packet(address: int, command: int, value: int) -> bytes:
    """Return a frame; only its address has the top bit set, so that a board finds the beginning of each.

    >>> list(packet(130, 0, 64))  # the manual's example: half speed forward
    [130, 0, 64, 66]
    """
    return bytes((address, command, value, address + command + value & 0x7F))


def drive(address: int, motor: MotorNumber, duty: float) -> bytes:
    """Return the frame that gives a motor a duty from -1 to 1.

    >>> list(drive(128, 2, -1.0))
    [128, 5, 127, 4]
    """
    value = round(duty * MOST)
    return packet(address, (4 if motor == 2 else 0) + (value < 0), abs(value))


def stop(address: int) -> bytes:
    """Return the frames that stop both motors."""
    return drive(address, 1, 0.0) + drive(address, 2, 0.0)


def in_tenths(seconds: float) -> float:
    """Return the time-out that a board has where it is asked for this one: whole tenths of a second, rounded up.

    >>> in_tenths(0.25)
    0.3
    """
    return max(math.ceil(min(seconds, MOST_TIMEOUT_S) * 10 - 1e-9), 1) / 10


def timeout(address: int, seconds: float) -> bytes:
    """Return the frame that has a board stop its motors after so long without a command; see `in_tenths`.

    It is off when the board is switched on, and forgotten when it is switched off.

    >>> list(timeout(128, 0.5))
    [128, 14, 5, 19]
    """
    return packet(address, _TIMEOUT, round(in_tenths(seconds) * 10))
