"""A serial port with the far end in our hands: a pseudo-terminal that can be unplugged and come back."""

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

WAITING_S = 5.0
"""The kernel hands bytes over some microseconds later, by a worker of its own; a machine may be busy."""

FULL = 4000
"""Some bytes fewer than the kernel keeps for who does not read (N_TTY_BUF_SIZE)."""


class Pty:
    """A port at ``path``, which stays the same when it is unplugged and plugged in again, as a by-id link does.

    It may be used from several threads.
    """

    def __init__(self, folder: Path, name: str = "board") -> None:
        self.path = folder / name
        self._far = self._near = -1
        self._lock = RLock()
        self.plug_in()

    def plug_in(self) -> None:
        """Make the port; a new one, as the kernel does."""
        with self._lock:
            self._far, self._near = os.openpty()
            tty.setraw(self._near)
            os.set_blocking(self._far, False)
            self.path.symlink_to(os.ttyname(self._near))

    def unplug(self) -> None:
        """Take the port away; who has it open finds it hung up."""
        with self._lock:
            self.path.unlink(missing_ok=True)
            for end in (self._far, self._near):
                os.close(end)
            self._far = self._near = -1

    @property
    def is_plugged_in(self) -> bool:
        return self._far >= 0

    def heard(self, wait_s: float = 0.0) -> bytes:
        """Return what was sent to the board, waiting so long for a first byte."""
        with self._lock:
            if self.is_plugged_in and select.select([self._far], [], [], wait_s)[0]:
                return os.read(self._far, 4096)
            return b""

    def say(self, data: bytes) -> None:
        """Send as the board; what nobody reads is lost some time."""
        with self._lock, suppress(BlockingIOError):
            if self.is_plugged_in:
                os.write(self._far, data)

    def all_heard(self) -> bytes:
        """Return all that was sent to the board before, also what the kernel has not handed over yet.

        A mark is sent after it, by the same way. Only where nobody else sends meanwhile: in simulated time.
        """
        with self._lock:
            if not self.is_plugged_in:
                return b""
            mark, heard = secrets.token_bytes(12), b""
            os.write(self._near, mark)
            while not heard.endswith(mark):
                more = self.heard(WAITING_S)
                assert more, "the kernel hands nothing over"
                heard += more
            return heard.removesuffix(mark)

    def say_all(self, data: bytes) -> None:
        """Send as the board, and wait until the kernel has handed it over; only where nobody reads meanwhile."""
        with self._lock:
            if data and self.is_plugged_in:
                there = min(self._waiting + len(data), FULL)
                self.say(data)
                while self._waiting < there:
                    select.select([], [], [], 0)

    @property
    def _waiting(self) -> int:
        """How many bytes whoever has the port open could read now."""
        told: bytes = fcntl.ioctl(self._near, termios.FIONREAD, bytes(4))
        return int(struct.unpack("i", told)[0])

    def close(self) -> None:
        """Take it away for good. May be called again."""
        if self.is_plugged_in:
            self.unplug()

    def __enter__(self) -> Pty:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
