"""Serial ports: find, open, read and write one, and say why one cannot be opened."""

from __future__ import annotations

import errno
import grp
import os
import re
import stat
import termios
from contextlib import suppress
from pathlib import Path
from select import select
from typing import TYPE_CHECKING

from robotcore.processes import describe_holders

if TYPE_CHECKING:
    from serial import Serial


USB = re.compile(r"usb:(?P<vendor>[0-9a-f]{4}):(?P<product>[0-9a-f]{4})(?::(?P<serial>.+))?", re.IGNORECASE)
"""A port by the USB id of what is plugged in."""


class PortMissingError(OSError):
    """There is no such port now; says which there are."""


def find_path(place: str) -> str:
    """Return the path by which a port is opened now; raises PortMissingError where it is not there."""
    if not (usb := USB.fullmatch(place)):
        if not Path(place).exists():
            raise PortMissingError(f"there is no {place}; {describe_ports()}")
        return place
    found = _plugged_in(int(usb["vendor"], 16), int(usb["product"], 16), usb["serial"])
    if not found:
        raise PortMissingError(f"{place} is not plugged in; {describe_ports()}")
    if len(found) > 1:
        raise PortMissingError(f"{place} is {len(found)} ports, {', '.join(found)}; add its serial number, or name one")
    return found[0]


def describe_ports() -> str:
    """Return which ports there are, in words, each with its USB id where it has one."""
    from serial.tools.list_ports import comports

    words = [f"{port.device} ({_usb_id(port.vid, port.pid)})" if port.vid else port.device for port in comports()]
    return f"there is {', '.join(sorted(words))}" if words else "no port is there at all"


def find_other_users(place: str) -> tuple[str, str] | None:
    """Return which other program has a port open without a lock, and what to do; None where none is seen."""
    with suppress(PortMissingError):
        if who := describe_holders(find_path(place)):
            return f"{place} is open in {who} too, and each gets a part of what the board says", "End that program"
    return None


def _plugged_in(vendor: int, product: int, serial: str | None) -> list[str]:
    from serial.tools.list_ports import comports

    return sorted(
        str(port.device)
        for port in comports()
        if (port.vid, port.pid) == (vendor, product) and serial in (None, port.serial_number)
    )


def _usb_id(vendor: int, product: int) -> str:
    return f"usb:{vendor:04x}:{product:04x}"


CHUNK = 4096

FAILURES = (OSError, termios.error, TypeError, ValueError)
"""What pyserial raises: its own errors are OSErrors, the system's are not translated, a closed port is a TypeError."""

WRITE_TIMEOUT_S = 0.05
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
            path = find_path(self.place)
            self._serial = Serial(path, self.baud, timeout=0, exclusive=True)
        except FAILURES as error:
            raise PortError(explain_failure(self.place, path, self.baud, error)) from error

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
            is_taken = select([], [file], [], WRITE_TIMEOUT_S)[1] and os.write(file, data) == len(data)
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
        who = describe_holders(str(self._serial.port)) if self._serial else ""
        reader = f", or {who} reads it too" if who else ""
        return PortError(f"{self.place} is gone: it was unplugged, or the board has no power{reader}. Plug it in again")


_HELD = {errno.EAGAIN, errno.EBUSY}
_CLOSED = {errno.EACCES, errno.EPERM}

ROOT = 0
"""The group of whoever may do everything: nobody is put into it for a port."""

GROUP_MAY = stat.S_IRGRP | stat.S_IWGRP


def explain_failure(place: str, path: str, baud: int, error: Exception) -> str:
    """Return why pyserial could not open the port at a place, which is at that path now, and what to do."""
    if isinstance(error, PortMissingError):
        return (
            f"{error}. Plug the board in, by a cable that carries data, or name another: port in the robot's file, or "
            "--port"
        )
    number = getattr(error, "errno", None)
    if number in _HELD:
        who = describe_holders(path) or "this program already, by another name, or a program that cannot be seen"
        return f"{place} is held by {who}. End that first"
    if number in _CLOSED:
        return f"no permission for {place}. {_permission(path)}"
    if isinstance(error, ValueError):
        return f"{place} cannot be set to {baud} baud ({error}). Correct baud in the robot's file, or take another port"
    return f"{place} cannot be opened as a serial port ({error}). Look whether it is one, and plug it in again"


def _permission(path: str) -> str:
    """Return how to get it: by the group whose members may use a port, on most systems dialout, on some uucp."""
    group = "dialout"
    with suppress(OSError, KeyError):
        status = os.stat(path)  # noqa: PTH116  as it is given
        if status.st_gid == ROOT or status.st_mode & GROUP_MAY != GROUP_MAY:
            return f"Only its owner may use it: sudo chgrp {group} {path} && sudo chmod g+rw {path}"
        group = grp.getgrgid(status.st_gid).gr_name
    return f"sudo usermod -aG {group} $USER, then log out and in again"
