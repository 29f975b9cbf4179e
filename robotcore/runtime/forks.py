"""Ends a copy of the process that an app's code made with ``os.fork``, because only one process may run the robot."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

EXIT_STATUS = 1
"""The exit status of the copy."""

_MESSAGE = (
    "error: {} called os.fork and returned in the new process {}. The new process ends, and the run continues. "
    "Start other programs with subprocess, and Python functions with multiprocessing\n"
)


@contextmanager
def end_forks(call: str) -> Iterator[None]:
    """Return a context at whose end a copy of the process ends.

    call: the app's code in the context, for the message.
    """
    process = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != process:
            end_fork(call)


def end_fork(call: str) -> NoReturn:
    """End this process, which is a copy that the app's code has made."""
    try:
        os.write(2, _MESSAGE.format(call, os.getpid()).encode())
    finally:
        os._exit(EXIT_STATUS)
