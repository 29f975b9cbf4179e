"""A serial port, by pyserial: raw bytes, and one error for all that can happen to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.serial.ports.place import path_of

if TYPE_CHECKING:
    from serial import Serial


class PortError(OSError):
    """A port cannot be opened, or is gone; says which one, why, and what to do."""


class Port:
    """Opens, reads and writes the port at a place; it may be opened again after it was closed.

    ``wait_s`` is how long `read` waits for a first byte, in seconds.
    """

    def __init__(self, place: str, baud: int, wait_s: float) -> None:
        self.place, self.baud, self._wait_s = place, baud, wait_s
        self._serial: Serial | None = None

    def open(self) -> None:
        """Open it, for this process alone; raises PortError."""
        from serial import Serial, SerialException

        try:
            path = path_of(self.place)
            self._serial = Serial(path, self.baud, timeout=self._wait_s, write_timeout=1.0, exclusive=True)
        except (SerialException, OSError, ValueError) as error:
            raise PortError(f"{self.place} cannot be opened: {error}") from error

    def read(self) -> bytes:
        """Return what has come in; raises PortError."""
        from serial import SerialException

        assert self._serial
        try:
            first = self._serial.read(1)
            return bytes(first + self._serial.read(self._serial.in_waiting)) if first else b""
        except (SerialException, OSError, TypeError) as error:
            raise PortError(f"{self.place} is gone: {error}") from error

    def write(self, data: bytes) -> None:
        """Send bytes; raises PortError."""
        from serial import SerialException

        assert self._serial
        try:
            self._serial.write(data)
        except (SerialException, OSError, TypeError) as error:
            raise PortError(f"{self.place} is gone: {error}") from error

    def wake(self) -> None:
        """Let whoever waits in `read` return now."""
        if self._serial:
            self._serial.cancel_read()

    def close(self) -> None:
        """Let it go. May be called again."""
        if self._serial:
            self._serial.close()
            self._serial = None
