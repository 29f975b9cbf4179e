"""Find, open, read and write serial ports, and explain why a port cannot be opened."""

from __future__ import annotations

import errno
import os
import re
from contextlib import suppress
from select import select
from typing import TYPE_CHECKING

from robotcore.processes import describe_holders
from robotcore.system import HAS_POSIX

if HAS_POSIX:
    from termios import error as TerminalError  # noqa: N812  it is a class
else:

    class TerminalError(Exception):
        """An error of a POSIX terminal, which no function raises on this system."""


if TYPE_CHECKING:
    from serial import Serial


USB = re.compile(r"usb:(?P<vendor>[0-9a-f]{4}):(?P<product>[0-9a-f]{4})(?::(?P<serial>.+))?", re.IGNORECASE)
"""The pattern of the USB id of a board or adapter, which a robot's file may have in place of a path."""


WINDOWS_NAME = re.compile(r"COM[1-9]\d{0,2}", re.IGNORECASE)
"""The pattern of the name of a port on Windows, where ports have no paths."""


class PortMissingError(OSError):
    """A port does not exist. The message lists the ports of the computer."""


def find_path(place: str) -> str:
    """Return the path of a port; raises PortMissingError if the port does not exist, or if several ports have its id.

    place: the path of the port, its name on Windows such as ``COM3``, or its USB id such as ``usb:1a86:7523``.
    """
    from serial.tools.list_ports import comports

    if WINDOWS_NAME.fullmatch(place):
        if place.upper() not in {str(port.device).upper() for port in comports()}:
            raise PortMissingError(f"there is no {place}; {describe_ports()}")
        return place
    if not (usb := USB.fullmatch(place)):
        if not os.path.exists(place):  # noqa: PTH110  it takes any name, however long
            raise PortMissingError(f"there is no {place}; {describe_ports()}")
        return place
    vendor, product, serial = int(usb["vendor"], 16), int(usb["product"], 16), usb["serial"]
    found = sorted(
        str(port.device)
        for port in comports()
        if (port.vid, port.pid) == (vendor, product) and serial in (None, port.serial_number)
    )
    if not found:
        raise PortMissingError(f"{place} is not plugged in; {describe_ports()}")
    if len(found) > 1:
        raise PortMissingError(
            f"{len(found)} ports have the id {place}: {', '.join(found)}; add the serial number, or write a path"
        )
    return found[0]


def describe_ports() -> str:
    """Return a text with all serial ports of this computer, each with its USB id if it has one."""
    from serial.tools.list_ports import comports

    words = [f"{port.device} (usb:{port.vid:04x}:{port.pid:04x})" if port.vid else port.device for port in comports()]
    return f"there is {', '.join(sorted(words))}" if words else "this computer has no serial port"


def find_other_users(place: str) -> tuple[str, str] | None:
    """Return the problem and the remedy if another program has the port open too; else None.

    Call it after this process has locked the port. Then no other program can open the port any more.
    """
    with suppress(PortMissingError):
        if holders := describe_holders(find_path(place)):
            return (
                f"{place} is open in {holders} too, and each program gets only a part of the data",
                "End that program",
            )
    return None


CHUNK = 4096
"""The largest number of bytes in one read."""

FAILURES = (OSError, TerminalError, TypeError, ValueError)
"""The errors that pyserial raises: its own are OSErrors, and the use of a closed port is a TypeError. The others are
errors of the operating system, which pyserial passes on."""

WRITE_TIMEOUT_S = 0.05
"""The longest time for writing a frame, in seconds. A longer time means that the port's buffer is full, because the
board does not read."""


class PortError(OSError):
    """A port cannot be opened, or was lost. The message has the port, the reason and the remedy."""


class Port:
    """A serial port, which this process locks while it is open. A closed port may be opened again.

    dtr: the level of the line DTR while the port is open. `close` inverts it, and the inverted level stays. With None,
        the system sets it: high while the port is open.
    """

    def __init__(self, place: str, baud: int, dtr: bool | None = None) -> None:  # noqa: FBT001  a level
        self.place, self.baud, self.dtr = place, baud, dtr
        self._serial: Serial | None = None

    def open(self) -> None:
        """Open the port and lock it, so that other programs cannot open it; raises PortError."""
        from serial import Serial

        path = self.place
        try:
            path = find_path(self.place)
            serial = Serial(None, self.baud, timeout=0, write_timeout=WRITE_TIMEOUT_S, exclusive=True)
            if self.dtr is not None:
                serial.dtr = self.dtr
            serial.port = path
            serial.open()
            self._serial = serial
        except FAILURES as error:
            raise PortError(explain_failure(self.place, path, self.baud, error)) from error

    @property
    def file(self) -> int | None:
        """The file descriptor of the port, for `select`; None if the port is closed, and on Windows, which has none."""
        return int(self._serial.fileno()) if self._serial and HAS_POSIX else None

    def read(self) -> bytes:
        """Return the bytes received so far, up to `CHUNK`, without a wait; raises PortError if the port is lost.

        It does not call pyserial's `in_waiting`, which fails on some pseudo-terminals.
        """
        assert self._serial
        try:
            return bytes(self._serial.read(CHUNK))
        except FAILURES as error:
            raise self._lost() from error

    def write(self, data: bytes) -> None:
        """Send bytes; raises PortError if the port does not take them within `WRITE_TIMEOUT_S`.

        On POSIX it calls `os.write`, because pyserial's `write` also reports a time-out if the operating system
        suspends this thread for that long.
        """
        from serial import SerialTimeoutException

        assert self._serial
        try:
            if HAS_POSIX:
                file = self._serial.fileno()
                is_taken = select([], [file], [], WRITE_TIMEOUT_S)[1] and os.write(file, data) == len(data)
            else:
                is_taken = self._serial.write(data) == len(data)
        except (BlockingIOError, SerialTimeoutException):
            is_taken = False
        except FAILURES as error:
            raise self._lost() from error
        if not is_taken:
            raise PortError(f"{self.place} takes no more bytes: the board does not read. Reset the board or replug it")

    @property
    def unsent(self) -> int:
        """The number of bytes that have not left the computer; 0 if the port cannot report this number."""
        with suppress(*FAILURES):
            return int(self._serial.out_waiting) if self._serial else 0
        return 0

    def close(self) -> None:
        """Close the port. May be called again.

        Unsent bytes are dropped, because otherwise closing would wait for a board that does not read.
        """
        if serial := self._serial:
            with suppress(*FAILURES):
                if self.unsent:
                    serial.reset_output_buffer()
            if self.dtr is not None:
                with suppress(*FAILURES):
                    _keep_lines(serial)
                    serial.dtr = not self.dtr
            serial.close()
            self._serial = None

    def _lost(self) -> PortError:
        holders = describe_holders(str(self._serial.port)) if self._serial else ""
        reader = f", or {holders} reads it too" if holders else ""
        return PortError(f"{self.place} is lost: it was unplugged, or the board has no power{reader}. Plug it in again")


def _keep_lines(serial: Serial) -> None:
    """Let the lines DTR and RTS of a port keep their levels when the port is closed. Windows has no such setting."""
    if not HAS_POSIX:
        return
    import termios

    file = serial.fileno()
    settings = termios.tcgetattr(file)
    settings[2] &= ~termios.HUPCL
    termios.tcsetattr(file, termios.TCSANOW, settings)


def explain_failure(place: str, path: str, baud: int, error: Exception) -> str:
    """Return the message for an error of opening a port: the reason and the remedy.

    place: the port in the robot's file, a path or a USB id.
    path: the path of the port.
    error: the error of pyserial or `find_path`.
    """
    if isinstance(error, PortMissingError):
        return (
            f"{error}. Plug the board in with a cable that carries data, or set another port, by port in the "
            "robot's file or by --port"
        )
    number = getattr(error, "errno", None)
    if not HAS_POSIX and "PermissionError" in str(error):  # pyserial has the error of Windows in its text only
        return f"{place} is held by another program, because Windows lets one program open it. End that program first"
    if number in (errno.EAGAIN, errno.EBUSY):
        holders = describe_holders(path) or "this program, by another path, or by a program of another user"
        return f"{place} is held by {holders}. End that program first"
    if number in (errno.EACCES, errno.EPERM):
        return f"no permission for {place}. {_permission_remedy(path)}"
    if isinstance(error, ValueError):
        return f"{place} cannot be set to {baud} baud ({error}). Correct baud in the robot's file, or use another port"
    return f"{place} cannot be opened as a serial port ({error}). Check that it is a serial port, and plug it in again"


def _permission_remedy(path: str) -> str:
    if not HAS_POSIX:
        return "End the program that has it open, or choose another port"
    import grp

    group = "dialout"  # or uucp: the group of the ports on most systems
    with suppress(OSError, KeyError):
        status = os.stat(path)  # noqa: PTH116  as it is given
        if (
            status.st_gid == 0 or status.st_mode & 0o060 != 0o060
        ):  # a remedy must not tell a user to join the group root
            return f"Only its owner may use it. Give it to a group: sudo chgrp {group} {path} && sudo chmod g+rw {path}"
        group = grp.getgrgid(status.st_gid).gr_name
    return f"sudo usermod -aG {group} $USER, then log out and in again"
