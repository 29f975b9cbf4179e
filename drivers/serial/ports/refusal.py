"""Why a port was not opened, in words for whoever is to mend it: pyserial tells an errno, or not even that."""

from __future__ import annotations

import errno
import grp
import os

from drivers.serial.ports.finding import PortMissingError, holders

_HELD = {errno.EAGAIN, errno.EBUSY}
_CLOSED = {errno.EACCES, errno.EPERM}


def why_closed(place: str, path: str, baud: int, error: Exception) -> str:
    """Return why pyserial could not open the port at a place, which is at that path now, and what to do."""
    if isinstance(error, PortMissingError):
        return (
            f"{error}. Plug the board in, by a cable that carries data, or name another: port in the robot's file, or "
            "--port"
        )
    number = getattr(error, "errno", None)
    if number in _HELD:
        who = holders(path) or "this program already, by another name, or a program that cannot be seen"
        return f"{place} is held by {who}. End that first"
    if number in _CLOSED:
        return f"no permission for {place}. sudo usermod -aG {group_of(path)} $USER, then log out and in again"
    if isinstance(error, ValueError):
        return f"{place} cannot be set to {baud} baud ({error}). Correct baud in the robot's file, or take another port"
    return f"{place} cannot be opened as a serial port ({error}). Look whether it is one, and plug it in again"


def group_of(path: str) -> str:
    """Return the group whose members may use a port: on most systems dialout, on some uucp."""
    try:
        return grp.getgrgid(os.stat(path).st_gid).gr_name  # noqa: PTH116  as it is given
    except (OSError, KeyError):
        return "dialout"
