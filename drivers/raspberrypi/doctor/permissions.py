"""Whether this user may use the board's devices: groups, and the device files themselves."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from drivers.raspberrypi.doctor.files import told
from robotcore.hal.finding import Finding

WHAT = "permissions"
KINDS = {"gpio": ("gpiochip*", "GPIO pins"), "i2c": ("i2c-1", "the I2C bus"), "video": ("video*", "cameras")}
"""By group: which files of /dev it may open, and what they are. Source: Raspberry Pi OS, 99-com.rules."""


def may_open(file: Path) -> bool:
    """Return whether this process may read and write a file."""
    return os.access(file, os.R_OK | os.W_OK)


def permissions(root: Path, may_open: Callable[[Path], bool] = may_open) -> Iterator[Finding]:
    """Look whether this process may open the devices that there are; what is not there is told elsewhere."""
    closed = {group: list(_closed(root, pattern, may_open)) for group, (pattern, _) in KINDS.items()}
    if not any(closed.values()):
        yield _open(root)
    for group, files in closed.items():
        if files:
            said = f"this user may not use {KINDS[group][1]} ({', '.join(files)})"
            yield Finding.error(WHAT, said, remedy_for(root, group))


def _open(root: Path) -> Finding:
    if there := ", ".join(what for pattern, what in KINDS.values() if list((root / "dev").glob(pattern))):
        return Finding.ok(WHAT, f"this user may use {there}")
    return Finding.warning(WHAT, "there are no pins, no I2C bus and no cameras in /dev", "Run it outside a container")


def _closed(root: Path, pattern: str, may_open: Callable[[Path], bool]) -> Iterable[str]:
    for file in sorted((root / "dev").glob(pattern)):
        if not may_open(file):
            yield f"/dev/{file.name}"


def remedy_for(root: Path, group: str) -> str:
    """Return what to do: a user who was put into a group has its rights from the next login on."""
    member, gid = _member_and_id(root, group)
    if gid in _groups_of_this_process(root):
        return f"The group {group} does not help: start the board again, or mend its udev rules"
    if member:
        return f"You are in the group {group} since this login: log out and in again, or restart the service"
    return f"sudo usermod -aG {group} $USER, then log out and in again"


def _member_and_id(root: Path, group: str) -> tuple[bool, str | None]:
    """Return whether this user is listed in a group, and the group's number. Source: group(5)."""
    user = os.environ.get("USER", "")
    for line in told(root / "etc/group").splitlines():
        name, _, gid, members = (*line.split(":"), "", "", "", "")[:4]
        if name == group:
            return bool(user) and user in members.split(","), gid
    return False, None


def _groups_of_this_process(root: Path) -> list[str]:
    """Return the numbers of its groups. Source: proc_pid_status(5)."""
    lines = told(root / "proc/self/status").splitlines()
    return next((line.split()[1:] for line in lines if line.startswith("Groups:")), [])
