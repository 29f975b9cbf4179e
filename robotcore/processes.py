"""Find the processes that hold a device, as far as Linux shows them in /proc."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

PROC = Path("/proc")

PSEUDO_TERMINALS = range(136, 144)
"""The major numbers of pseudo-terminals. Source: Linux, Documentation/admin-guide/devices.txt."""

GUARDIAN_PACKAGE = b"robotcore.safety.guardian."


@dataclass(frozen=True)
class OpenFile:
    """A file that a process has open."""

    process: int
    #: The number of the file in that process.
    number: int
    #: The text of the link in /proc/PID/fd: a path, or a name such as ``anon_inode:gpio-line``.
    link: str


def list_open_files(proc: Path = PROC) -> Iterator[OpenFile]:
    """Yield the open files of all processes, in the order of the processes' numbers.

    Linux shows the files of other users' processes to root only.
    """
    for process in sorted(proc.glob("[0-9]*"), key=lambda folder: int(folder.name)):
        with suppress(OSError):  # the process has ended, or is another user's
            for file in (process / "fd").iterdir():
                with suppress(OSError):  # the process has closed it meanwhile
                    yield OpenFile(int(process.name), int(file.name), str(file.readlink()))


def find_holders(path: str) -> list[int]:
    """Return the numbers of the other processes that have a device open, or have a lock on it.

    Linux shows the locks of all processes to each user, but open files as `list_open_files` says.
    """
    try:
        device = os.stat(path)  # noqa: PTH116  as it is given
    except OSError:
        return []
    openers = {file.process for file in list_open_files() if _is_open_on(file, device)}
    return sorted((openers | _find_lockers(device)) - {os.getpid()})


def describe_holders(path: str) -> str:
    """Return the other processes that hold a device: ``process 1234 (picocom)``; empty if none is found."""
    return " and ".join(describe_process(number) for number in find_holders(path))


def describe_process(number: int, proc: Path = PROC) -> str:
    """Return a process's number and name: ``process 1234 (picocom)``; the number only if it has ended."""
    process = proc / str(number)
    try:
        is_guardian = GUARDIAN_PACKAGE in (process / "cmdline").read_bytes()
        name = "the guardian of a run" if is_guardian else (process / "comm").read_text().strip()
    except OSError:
        return f"process {number}"
    return f"process {number} ({name})"


def is_same_device(first: os.stat_result, second: os.stat_result) -> bool:
    """Return whether two files are one device, by whatever paths they were reached.

    A device may have several nodes, in a container for example: they have its number in common. The numbers of
    pseudo-terminals begin at 0 in each container, so these are one device only if their node is the same.
    """
    if os.path.samestat(first, second):
        return True
    if not (stat.S_ISCHR(first.st_mode) and stat.S_ISCHR(second.st_mode)):
        return False
    return first.st_rdev == second.st_rdev and os.major(first.st_rdev) not in PSEUDO_TERMINALS


def _is_open_on(file: OpenFile, device: os.stat_result) -> bool:
    """Compare devices and not paths: a container's /dev/pts/3 has the path of the host's and is another device."""
    if not file.link.startswith("/"):  # a pipe, a socket
        return False
    try:
        return is_same_device((PROC / f"{file.process}/fd/{file.number}").stat(), device)
    except OSError:  # the process has closed it meanwhile
        return False


def _find_lockers(file: os.stat_result) -> set[int]:
    """Return the processes that have a lock on a file, by flock(2). Source: proc_locks(5)."""
    try:
        locks = (PROC / "locks").read_text()
    except OSError:
        return set()
    where = f"{os.major(file.st_dev):02x}:{os.minor(file.st_dev):02x}:{file.st_ino}"
    lines = (line.split() for line in locks.splitlines())
    numbers = {int(each[4]) for each in lines if len(each) > 5 and each[5] == where and each[1] != "->"}
    return {number for number in numbers if number > 0}  # -1 is a lock of an open file, with no process
