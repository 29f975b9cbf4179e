"""A process that holds lines, and has to end for somebody else to get them."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path
from select import select

_FLAGS = 6
"""Where /proc/PID/stat has the flags of a process, counted from behind its name. Source: proc_pid_stat(5)."""

_IS_EXITING = 0x4
"""PF_EXITING. Source: Linux, include/linux/sched.h."""


class Owner:
    """A process of another's, and never the one that gets its number later."""

    def __init__(self, number: int) -> None:
        """Take hold of a process that lives; ProcessLookupError where it does not."""
        self._number = number
        self._handle = os.pidfd_open(number)

    def is_ending(self) -> bool:
        """Return whether its end has begun, for whatever reason; threads of it may still be at work."""
        if self.has_ended_within(0.0):
            return True
        try:
            stat = Path(f"/proc/{self._number}/stat").read_text()
        except (FileNotFoundError, ProcessLookupError):
            return True
        return bool(int(stat.rpartition(")")[2].split()[_FLAGS]) & _IS_EXITING)

    def kill(self) -> None:
        """End it, also one that is suspended or hangs."""
        with suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._handle, signal.SIGKILL)

    def has_ended_within(self, seconds: float) -> bool:
        """Return whether it has ended, all its files closed, after waiting no longer than this."""
        return bool(select([self._handle], [], [], seconds)[0])

    def close(self) -> None:
        os.close(self._handle)
