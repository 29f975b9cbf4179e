"""The serial port on the 40-pin header: what it is called, and which pins are its own.

Source: https://www.raspberrypi.com/documentation/computers/configuration.html#configuring-uarts
"""

from __future__ import annotations

from robotcore.hardware import Connection

NAMES = ("/dev/serial0", "/dev/ttyAMA0", "/dev/ttyS0")
"""``serial0`` up to a Pi 4, where it is one of the other two; ``ttyAMA0`` on a Pi 5."""

_LINES = (("sends", "14"), ("hears", "15"))
"""TXD and RXD."""


NOTE = (
    "The port sends on GPIO 14, to the board's RX, and hears on GPIO 15, from its TX, both at 3.3 V: a TX of 5 V, such "
    "as an Arduino Uno's, needs a divider, 1 kΩ to GPIO 15 and 2 kΩ from there to ground, or the board goes on USB. On "
    "a Pi 5 the port is /dev/ttyAMA0."
)
"""What whoever connects something to it must know."""


def is_header_port(wire: Connection) -> bool:
    """Return whether a device's wire is the port on the header, by the name that it has there."""
    return wire.bus == "serial" and wire.where in NAMES


def lines_of(wire: Connection) -> tuple[Connection, ...]:
    """Return the pins that a wire takes as a port; none where it is no port on the header."""
    if not is_header_port(wire):
        return ()
    return tuple(Connection(signal, "GPIO", gpio, wire.is_shared, spoken=wire.spoken) for signal, gpio in _LINES)
