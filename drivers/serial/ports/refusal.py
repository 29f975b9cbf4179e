"""Why a port was not opened, in words for whoever is to mend it: pyserial tells an errno, or not even that."""

from __future__ import annotations

import errno
import grp
import os
import stat
from contextlib import suppress

from drivers.serial.ports.finding import PortMissingError, holders

_HELD = {errno.EAGAIN, errno.EBUSY}
_CLOSED = {errno.EACCES, errno.EPERM}

ROOT = 0
"""The group of whoever may do everything: nobody is put into it for a port."""

GROUP_MAY = stat.S_IRGRP | stat.S_IWGRP


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
