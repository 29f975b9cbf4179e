"""Finding a serial port: what it is called now, which others there are, and who has one. It imports little."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path

USB = re.compile(r"usb:(?P<vendor>[0-9a-f]{4}):(?P<product>[0-9a-f]{4})(?::(?P<serial>.+))?", re.IGNORECASE)
"""A port by the USB id of what is plugged in."""

_PROC = Path("/proc")


class PortMissingError(OSError):
    """There is no such port now; says which there are."""


def path_of(place: str) -> str:
    """Return the path by which a port is opened now; raises PortMissingError where it is not there."""
    if not (usb := USB.fullmatch(place)):
        if not Path(place).exists():
            raise PortMissingError(f"there is no {place}; {those_there()}")
        return place
    found = _plugged_in(int(usb["vendor"], 16), int(usb["product"], 16), usb["serial"])
    if not found:
        raise PortMissingError(f"{place} is not plugged in; {those_there()}")
    if len(found) > 1:
        raise PortMissingError(f"{place} is {len(found)} ports, {', '.join(found)}; add its serial number, or name one")
    return found[0]


def those_there() -> str:
    """Return which ports there are, in words, each with its USB id where it has one."""
    from serial.tools.list_ports import comports

    words = [f"{port.device} ({_usb_id(port.vid, port.pid)})" if port.vid else port.device for port in comports()]
    return f"there is {', '.join(sorted(words))}" if words else "no port is there at all"


def holders(path: str) -> str:
    """Return which other processes have a port open: ``process 1234 (picocom)``; nothing where none is seen.

    Who locks it is seen by everyone; who only has it open, of other users' processes by root alone.
    """
    numbers = {*_locking(path), *_having_open(path)} - {os.getpid()}
    return " and ".join(f"process {number}{_name(number)}" for number in sorted(numbers))


def also_open(place: str) -> tuple[str, str] | None:
    """Return which other program has a port open without a lock, and what to do; None where none is seen."""
    with suppress(PortMissingError):
        if who := holders(path_of(place)):
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


def _locking(path: str) -> set[int]:
    """Return the processes with a lock on a file, by flock(2). Source: proc_locks(5)."""
    try:
        file, locks = Path(path).stat(), (_PROC / "locks").read_text()
    except OSError:
        return set()
    where = f"{os.major(file.st_dev):02x}:{os.minor(file.st_dev):02x}:{file.st_ino}"
    words = (line.split() for line in locks.splitlines())
    return {int(each[4]) for each in words if len(each) > 5 and each[5] == where and each[1] != "->"}


def _having_open(path: str) -> set[int]:
    real = os.path.realpath(path)
    found = set()
    for process in _PROC.glob("[0-9]*"):
        with suppress(OSError):  # gone, or another user's
            if any(_is_link_to(real, file) for file in (process / "fd").iterdir()):
                found.add(int(process.name))
    return found


def _is_link_to(real: str, file: Path) -> bool:
    try:
        return str(file.readlink()) == real
    except OSError:  # closed meanwhile
        return False


def _name(number: int) -> str:
    process = _PROC / str(number)
    try:
        is_guardian = b"robotcore.safety.guardian." in (process / "cmdline").read_bytes()
        return " (the guardian of a run)" if is_guardian else f" ({(process / 'comm').read_text().strip()})"
    except OSError:
        return ""
