"""Where a device's wires go."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Connection:
    """One wire or plug of a device: what goes over it, and where it goes.

    ``signal`` is the device's own word (trigger, SDA), ``bus`` the kind of place (GPIO, I2C, CSI, USB, serial) and
    ``where`` the place on it. What ``is_shared`` may have several devices; anything else has one.

    >>> str(Connection("trigger", "GPIO", "16"))
    'GPIO 16'
    """

    signal: str
    bus: str
    where: str
    is_shared: bool = False

    def __str__(self) -> str:
        return f"{self.bus} {self.where}"
