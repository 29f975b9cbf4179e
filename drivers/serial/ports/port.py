"""A serial port, by pyserial: raw bytes, and one error for all that can happen to it."""

from __future__ import annotations

import os
import termios
from contextlib import suppress
from select import select
from typing import TYPE_CHECKING

from drivers.serial.ports.finding import holders, path_of
from drivers.serial.ports.refusal import why_closed

if TYPE_CHECKING:
    from serial import Serial

CHUNK = 4096

FAILURES = (OSError, termios.error, TypeError, ValueError)
"""What pyserial raises: its own errors are OSErrors, the system's are not translated, a closed port is a TypeError."""

WRITING_S = 0.05
"""A port that has not taken a frame by then takes none: its buffer, which is larger, is full."""


class PortError(OSError):
    """A port cannot be opened, or is gone; says which one, why, and what to do."""


class Port:
    """Opens, reads and writes the port at a place; it may be opened again after it was closed."""

    def __init__(self, place: str, baud: int) -> None:
        self.place, self.baud = place, baud
        self._serial: Serial | None = None

    def open(self) -> None:
        """Open it, for this process alone; raises PortError."""
        from serial import Serial

        path = self.place
        try:
            path = path_of(self.place)
            self._serial = Serial(path, self.baud, timeout=0, exclusive=True)
        except FAILURES as error:
            raise PortError(why_closed(self.place, path, self.baud, error)) from error

    @property
    def file(self) -> int | None:
        """The file that can be waited for; None where it is not open."""
        return int(self._serial.fileno()) if self._serial else None

    def read(self) -> bytes:
        """Return what has come in, without waiting; raises PortError.

        pyserial reads nothing for ever after a hang-up, and says so; `in_waiting`, which a pseudo-terminal may not
        have, is not asked.
        """
        assert self._serial
        try:
            return bytes(self._serial.read(CHUNK))
        except FAILURES as error:
            raise self._gone() from error

    def write(self, data: bytes) -> None:
        """Send bytes, within a moment; raises PortError.

        By the system, not by pyserial: that raises its time-out also where all was written, if this thread was not
        given the processor for so long.
        """
        assert self._serial
        try:
            file = self._serial.fileno()
            is_taken = select([], [file], [], WRITING_S)[1] and os.write(file, data) == len(data)
        except BlockingIOError:
            is_taken = False
        except FAILURES as error:
            raise self._gone() from error
        if not is_taken:
            raise PortError(f"{self.place} takes no more bytes: the board does not read. Reset it, or plug it in again")

    @property
    def unsent(self) -> int:
        """How many bytes have not left the computer, as far as the port tells."""
        with suppress(*FAILURES):
            return int(self._serial.out_waiting) if self._serial else 0
        return 0

    def close(self) -> None:
        """Let it go, with what has not left: a board that does not read would be waited for. May be called again."""
        if serial := self._serial:
            with suppress(*FAILURES):
                if self.unsent:
                    serial.reset_output_buffer()
            serial.close()
            self._serial = None

    def _gone(self) -> PortError:
        who = holders(str(self._serial.port)) if self._serial else ""
        reader = f", or {who} reads it too" if who else ""
        return PortError(f"{self.place} is gone: it was unplugged, or the board has no power{reader}. Plug it in again")
