"""A serial port with its far end: a pseudo-terminal that can be unplugged and plugged in again."""

from __future__ import annotations

import fcntl
import os
import secrets
import select
import struct
import termios
import tty
from contextlib import suppress
from pathlib import Path
from threading import RLock

from robotcore.hal.wall_clock import MonotonicClock

WAITING_S = 20.0
"""The longest wait for the kernel, which passes bytes on some microseconds later; a busy machine took over a second."""

FULL = 4000
"""A few bytes less than the kernel keeps unread (N_TTY_BUF_SIZE)."""


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
        """Make a new port."""
        with self._lock:
            self._far, self._near = os.openpty()
            tty.setraw(self._near)
            for end in (self._far, self._near):
                os.set_blocking(end, False)
            self.path.symlink_to(os.ttyname(self._near))

    def unplug(self) -> None:
        """Remove the port; a process that has it open gets a hang-up."""
        with self._lock:
            self.path.unlink(missing_ok=True)
            for end in (self._far, self._near):
                os.close(end)
            self._far = self._near = -1

    @property
    def is_plugged_in(self) -> bool:
        return self._far >= 0

    def heard(self, wait_s: float = 0.0) -> bytes:
        """Return the bytes for the board; wait ``wait_s`` for the first one."""
        with self._lock:
            if self.is_plugged_in and select.select([self._far], [], [], wait_s)[0]:
                return os.read(self._far, 4096)
            return b""

    def say(self, data: bytes) -> int:
        """Send as the board; return the number of bytes that the kernel took, less than all if its buffer is full."""
        with self._lock, suppress(BlockingIOError):
            if self.is_plugged_in:
                return os.write(self._far, data)
        return 0

    def all_heard(self) -> bytes:
        """Return all bytes for the board, also those that the kernel has not passed on yet.

        It sends a mark behind them. No other thread may send meanwhile, so this is for simulated time.
        """
        with self._lock:
            if not self.is_plugged_in:
                return b""
            mark, heard, clock = secrets.token_bytes(12), b"", MonotonicClock()
            taken = 0
            with suppress(BlockingIOError):
                taken = os.write(self._near, mark)
            assert taken == len(mark), f"{self.path}: the kernel took {taken} bytes of a mark of {len(mark)}"
            while not heard.endswith(mark):
                heard += self.heard(max(0.0, WAITING_S - clock.now()))
                assert heard.endswith(mark) or clock.now() < WAITING_S, (
                    f"{self.path}: no mark in {WAITING_S:g} s, at the end of the {len(heard)} bytes that came: "
                    f"somebody else reads or sends ({heard[-50:]!r})"
                )
            return heard.removesuffix(mark)

    def say_all(self, data: bytes) -> None:
        """Send as the board, and wait until the kernel has passed it on; no other thread may read meanwhile."""
        with self._lock:
            if data and self.is_plugged_in:
                before, clock = self._waiting, MonotonicClock()
                there, taken = min(before + len(data), FULL), self.say(data)
                while (waiting := self._waiting) < there:
                    assert clock.now() < WAITING_S, (
                        f"{self.path}: {before} bytes waited to be read, the kernel took {taken} of {len(data)} more, "
                        f"and after {WAITING_S:g} s {waiting} wait: it has not handed them over, or somebody reads"
                    )
                    select.select([], [], [], 0)

    @property
    def _waiting(self) -> int:
        """The number of bytes that can be read from the port now."""
        count: bytes = fcntl.ioctl(self._near, termios.FIONREAD, bytes(4))
        return int(struct.unpack("i", count)[0])

    def close(self) -> None:
        """Remove the port for good. May be called again."""
        if self.is_plugged_in:
            self.unplug()

    def __enter__(self) -> Pty:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
