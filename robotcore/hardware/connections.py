"""Where a device's wires go."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Connection:
    """One wire or plug of a device: what goes over it, and where it goes.

    ``signal`` is the device's own word (trigger, SDA), ``bus`` the kind of place (GPIO, I2C, CSI, USB, serial) and
    ``where`` the place on it. What ``is_shared`` may have several devices; anything else has one. ``instead`` is what
    else to do where two devices have that signal on one place, such as to take another key that they may share.
    ``spoken`` is what is said on a wire where it matters: only those that speak the same share it.

    >>> str(Connection("trigger", "GPIO", "16"))
    'GPIO 16'
    """

    signal: str
    bus: str
    where: str
    is_shared: bool = False
    instead: str = field(default="", compare=False)
    spoken: str = ""

    def __str__(self) -> str:
        return f"{self.bus} {self.where}"

    def shares(self, other: Connection) -> bool:
        """Return whether both may go to one place."""
        is_alike = (self.signal, self.spoken) == (other.signal, other.spoken)
        return is_alike and self.is_shared and other.is_shared
