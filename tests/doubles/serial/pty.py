"""A pseudo-terminal as a serial port that can be unplugged and plugged in again."""

from __future__ import annotations

import os
import secrets
import select
import sys
from contextlib import suppress
from pathlib import Path
from threading import RLock

import pytest

from robotcore.hal.wall_clock import MonotonicClock

try:
    import fcntl
    import termios
    import tty
except ModuleNotFoundError:
    pytest.skip("a pseudo-terminal needs POSIX", allow_module_level=True)

WAITING_S = 20.0
"""The longest wait for the kernel, which usually passes bytes on within microseconds.

A busy machine took over a second.
"""

FULL = 4000
"""A few bytes less than the kernel's buffer of unread bytes (N_TTY_BUF_SIZE)."""


class Pty:
    """A port at ``path``, which stays the same after replugging, like a by-id link.

    Several threads may use it.
    """

    def __init__(self, folder: Path, name: str = "board") -> None:
        self.path = folder / name
        self._far = self._near = -1
        self._lock = RLock()
        self.plug_in()

    def plug_in(self) -> None:
        """Create a new port with the same path."""
        with self._lock:
            self._far, self._near = os.openpty()
            tty.setraw(self._near)
            for end in (self._far, self._near):
                os.set_blocking(end, False)
            self.path.symlink_to(os.ttyname(self._near))

    def unplug(self) -> None:
        """Remove the port. A process that has it open gets a hang-up."""
        with self._lock:
            self.path.unlink(missing_ok=True)
            for end in (self._far, self._near):
                os.close(end)
            self._far = self._near = -1

    @property
    def is_plugged_in(self) -> bool:
        return self._far >= 0

    def read(self, wait_s: float = 0.0) -> bytes:
        """Return the bytes for the board; wait up to ``wait_s`` seconds for the first byte."""
        with self._lock:
            if self.is_plugged_in and select.select([self._far], [], [], wait_s)[0]:
                return os.read(self._far, 4096)
            return b""

    def send(self, data: bytes) -> int:
        """Send bytes as the board; return how many bytes the kernel took. A full buffer takes fewer bytes."""
        with self._lock, suppress(BlockingIOError):
            if self.is_plugged_in:
                return os.write(self._far, data)
        return 0

    def read_all(self) -> bytes:
        """Return all bytes for the board, also those that the kernel has not passed on yet.

        The method writes a marker byte behind them, and reads up to this byte. No other thread may send during the
        call, so use it in simulated time only.
        """
        with self._lock:
            if not self.is_plugged_in:
                return b""
            mark, data_read, clock = secrets.token_bytes(12), b"", MonotonicClock()
            os.write(self._near, mark)
            while not data_read.endswith(mark):
                data_read += self.read(max(0.0, WAITING_S - clock.now()))
                assert clock.now() < WAITING_S, f"no mark at the end of {data_read[-50:]!r}: another thread sends"
            return data_read.removesuffix(mark)

    def send_all(self, data: bytes) -> None:
        """Send as the board, and wait until the kernel has passed the bytes on.

        No other thread may read during the call.
        """
        with self._lock:
            if data and self.is_plugged_in:
                clock, expected = MonotonicClock(), min(self._waiting + len(data), FULL)
                self.send(data)
                while self._waiting < expected:
                    assert clock.now() < WAITING_S, f"{data!r} does not arrive: another thread reads"
                    select.select([], [], [], 0)

    @property
    def _waiting(self) -> int:
        count: bytes = fcntl.ioctl(self._near, termios.FIONREAD, bytes(4))
        return int.from_bytes(count, sys.byteorder)

    def close(self) -> None:
        """Remove the port. May be called again."""
        if self.is_plugged_in:
            self.unplug()

    def __enter__(self) -> Pty:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
