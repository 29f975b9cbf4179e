"""The supervisor: the parent process of a worker process, which ends all descendants of the worker.

An app may start a process in another session. A signal to the worker's process group does not reach such a process,
which keeps standard error open while it runs. On Linux the supervisor adopts each process that loses its parent
(``PR_SET_CHILD_SUBREAPER``). So all descendants of the worker become its children. Other systems lack this option, so
this module is for Linux.
"""

from __future__ import annotations

import ctypes
import os
import resource
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from socket import socket
from typing import NoReturn

from robotcore.hal.wall_clock import MonotonicClock

_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
"""The option of ``prctl`` that makes a process adopt orphaned descendants. Source: Linux, ``prctl.h``."""

_ENDING_S = 5.0
"""The time limit for ending child processes, in seconds. The supervisor cannot end a process of another user."""

_POLL_S = 0.05
_SIGNALS = (signal.SIGTERM, signal.SIGCHLD)


def supervise(link: socket) -> None:
    """Fork this process. The parent becomes the supervisor and never returns. The child returns and is the worker.

    link: the worker's end of its link. The supervisor closes its copy.

    On SIGTERM the supervisor ends the worker. It exits with the worker's exit status. If the supervisor dies, the
    kernel ends the worker.
    """
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_DFL)  # a process inherits the signals that its parent ignores
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
    supervisor = os.getpid()
    if worker := os.fork():
        link.close()
        _watch(worker)
    os.setsid()
    _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != supervisor:  # the supervisor died before the call above
        os._exit(1)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _prctl(option: int, value: int) -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(option, ctypes.c_ulong(value), 0, 0, 0):
        raise OSError(ctypes.get_errno(), f"prctl({option})")


def _watch(worker: int) -> NoReturn:
    while (status := dict(_reap_children()).get(worker)) is None:
        if signal.sigwait(_SIGNALS) == signal.SIGTERM:
            os.kill(worker, signal.SIGKILL)
    _end_children()
    _exit_as(status)


def _reap_children() -> Iterator[tuple[int, int]]:
    with suppress(ChildProcessError):
        while (ended := os.waitpid(-1, os.WNOHANG))[0]:
            yield ended


def _end_children() -> None:
    """End every child process. When a child ends, this process adopts the child's own children, and ends them too."""
    clock = MonotonicClock()
    while clock.now() < _ENDING_S and (children := list(_list_children())):
        for child in children:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(child, signal.SIGKILL)
        signal.sigtimedwait((signal.SIGCHLD,), _POLL_S)
        dict(_reap_children())


def _list_children() -> Iterator[int]:
    """Yield the process id of each child. Format: proc(5). The fields follow the name, which is in parentheses."""
    for file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # the process has just ended
            if int(file.read_bytes().rpartition(b")")[2].split()[1]) == os.getpid():
                yield int(file.parent.name)


def _exit_as(status: int) -> NoReturn:
    """Exit with the worker's exit status, or by the signal that ended the worker, without a second core file.

    status: the worker's status from ``waitpid``.
    """
    if os.WIFSIGNALED(status):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        number = os.WTERMSIG(status)
        with suppress(OSError):  # SIGKILL cannot have a handler
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        os.kill(os.getpid(), number)
    os._exit(os.waitstatus_to_exitcode(status) if os.WIFEXITED(status) else 1)
