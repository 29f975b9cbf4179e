"""Finds the processes that have a device open or locked. The source is /proc of Linux."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from robotcore.system import IS_LINUX

PROC = Path("/proc")

PSEUDO_TERMINALS = range(136, 144)
"""The major numbers of pseudo-terminals. Source: Linux, Documentation/admin-guide/devices.txt."""

GUARDIAN_PACKAGE = b"robotcore.safety.guardian."


@dataclass(frozen=True)
class OpenFile:
    """A file that a process has open."""

    process: int
    """The PID of the process."""
    number: int
    """The file descriptor in the process."""
    link: str
    """The target of the link in /proc/PID/fd: a path, or a name such as ``anon_inode:gpio-line``."""


def list_open_files(proc: Path = PROC) -> Iterator[OpenFile]:
    """Yield the open files of all processes, sorted by PID.

    Without root rights, only the files of the user's own processes are visible.
    """
    for process in sorted(proc.glob("[0-9]*"), key=lambda folder: int(folder.name)):
        with suppress(OSError):  # the process has ended, or belongs to another user
            for file in (process / "fd").iterdir():
                with suppress(OSError):  # the process has just closed the file
                    yield OpenFile(int(process.name), int(file.name), str(file.readlink()))


def find_holders(path: str) -> list[int]:
    """Return the PIDs of all processes, except this one, that have a device open or locked.

    All users can see locks. Only root can see the open files of other users' processes. The list is empty on another
    system than Linux.
    """
    if not IS_LINUX:
        return []
    try:
        device = os.stat(path)  # noqa: PTH116  the path is a text
    except OSError:
        return []
    openers = {file.process for file in list_open_files() if _is_open_on(file, device)}
    return sorted((openers | _find_lockers(device)) - {os.getpid()})


def describe_holders(path: str) -> str:
    """Return a text such as ``process 1234 (picocom)`` that names the processes of `find_holders`.

    The text is empty if there are none.
    """
    return " and ".join(describe_process(number) for number in find_holders(path))


def describe_process(number: int, proc: Path = PROC) -> str:
    """Return a text such as ``process 1234 (picocom)``, or ``process 1234`` if the process has ended.

    number: the PID of the process.
    proc: the folder that is mounted as /proc.
    """
    process = proc / str(number)
    try:
        is_guardian = GUARDIAN_PACKAGE in (process / "cmdline").read_bytes()
        name = "the guardian of a run" if is_guardian else (process / "comm").read_text().strip()
    except OSError:
        return f"process {number}"
    return f"process {number} ({name})"


def is_same_device(first: os.stat_result, second: os.stat_result) -> bool:
    """Return whether two files are the same device. The arguments are the ``stat`` results of the files.

    A device may have several files, for example in containers, all with the same device number. But two
    pseudo-terminals with one number may differ, because each container numbers its own from 0. So pseudo-terminals must
    be the same file.
    """
    if os.path.samestat(first, second):
        return True
    if not (stat.S_ISCHR(first.st_mode) and stat.S_ISCHR(second.st_mode)):
        return False
    return first.st_rdev == second.st_rdev and os.major(first.st_rdev) not in PSEUDO_TERMINALS


def _is_open_on(file: OpenFile, device: os.stat_result) -> bool:
    # Paths are not compared, because each container has its own paths.
    if not file.link.startswith("/"):  # a pipe, a socket
        return False
    try:
        return is_same_device((PROC / f"{file.process}/fd/{file.number}").stat(), device)
    except OSError:  # the process has just closed the file
        return False


def _find_lockers(file: os.stat_result) -> set[int]:
    """Return the PIDs of the processes that have locked a file with flock(2). Source: proc_locks(5)."""
    try:
        locks = (PROC / "locks").read_text()
    except OSError:
        return set()
    where = f"{os.major(file.st_dev):02x}:{os.minor(file.st_dev):02x}:{file.st_ino}"
    lines = (line.split() for line in locks.splitlines())
    numbers = {int(each[4]) for each in lines if len(each) > 5 and each[5] == where and each[1] != "->"}
    return {number for number in numbers if number > 0}  # -1: a lock that belongs to no process
