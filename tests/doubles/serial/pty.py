"""A serial port with the far end in our hands: a pseudo-terminal that can be unplugged and come back."""

from __future__ import annotations

import os
import select
import tty
from pathlib import Path
from threading import RLock


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
        """Send as the board."""
        with self._lock:
            if self.is_plugged_in:
                os.write(self._far, data)

    def close(self) -> None:
        """Take it away for good. May be called again."""
        if self.is_plugged_in:
            self.unplug()

    def __enter__(self) -> Pty:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
