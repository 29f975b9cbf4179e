"""Find the processes that hold a device, as far as Linux shows them in /proc."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

PROC = Path("/proc")

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
    real = os.path.realpath(path)
    found = {file.process for file in list_open_files() if file.link == real}
    return sorted((found | _find_lockers(path)) - {os.getpid()})


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


def _find_lockers(path: str) -> set[int]:
    """Return the processes that have a lock on a file, by flock(2). Source: proc_locks(5)."""
    try:
        file, locks = Path(path).stat(), (PROC / "locks").read_text()
    except OSError:
        return set()
    where = f"{os.major(file.st_dev):02x}:{os.minor(file.st_dev):02x}:{file.st_ino}"
    lines = (line.split() for line in locks.splitlines())
    return {int(each[4]) for each in lines if len(each) > 5 and each[5] == where and each[1] != "->"}
