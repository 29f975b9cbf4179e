"""Waiting for bytes, or for another thread's word."""

from __future__ import annotations

from contextlib import suppress
from select import select
from socket import socketpair


class Waker:
    """Lets a thread wait that another one can wake; a word that comes before the wait is not lost."""

    def __init__(self) -> None:
        self._woken, self._waking = socketpair()
        self._woken.setblocking(False)
        self._waking.setblocking(False)

    def wake(self) -> None:
        """Let whoever waits, or is about to, go on."""
        with suppress(OSError):  # full: it has been woken; closed: nobody waits
            self._waking.send(b"w")

    def wait(self, file: int | None, seconds: float) -> None:
        """Wait until a file has something to read, for a word, or for so long."""
        files = [self._woken.fileno()] if file is None else [self._woken.fileno(), file]
        select(files, [], [], seconds)
        with suppress(BlockingIOError):
            self._woken.recv(4096)

    def close(self) -> None:
        """Wait no more. May be called again."""
        self._woken.close()
        self._waking.close()
