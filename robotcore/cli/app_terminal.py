"""Give an app a terminal of its own, while another part of the program reads the real one."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import Any

BUFFER = 1024


class AppTerminal:
    """A pseudo-terminal that stands in for stdin, from the creation of the object until `close`.

    The app reads the keys that are given to `pass_on`. No method waits, so the e-stop never waits for the app.

    stdin: the descriptor of the real terminal that the pseudo-terminal stands in for.
    mode: the real terminal's mode, as `termios.tcgetattr` returns it. The pseudo-terminal begins with it.

    Raises OSError if the system has no pseudo-terminal left.
    """

    def __init__(self, stdin: int, mode: list[Any]) -> None:
        import fcntl
        import termios

        self._stdin = stdin
        self._mode = mode
        self.output, self._input = os.openpty()
        """The descriptor that gives the echo of the keys. See `read_echo`."""
        os.set_blocking(self.output, False)
        termios.tcsetattr(self._input, termios.TCSANOW, mode)
        fcntl.ioctl(self._input, termios.TIOCSWINSZ, fcntl.ioctl(stdin, termios.TIOCGWINSZ, bytes(8)))
        self.real = os.dup(stdin)
        """A descriptor of the real terminal."""
        os.dup2(self._input, stdin)

    def pass_on(self, keys: bytes) -> None:
        """Give keys to the app. Keys are lost if the app has left some thousand keys unread."""
        with suppress(OSError):
            os.write(self.output, keys)

    def read_echo(self) -> bytes:
        """Return what the pseudo-terminal shows, or nothing."""
        with suppress(OSError):
            return os.read(self.output, BUFFER)
        return b""

    def close(self) -> None:
        """Restore stdin, and end a read of the app that still waits. Later calls do nothing.

        The pseudo-terminal remains open until the process ends, because a thread of the app may still read from it.
        """
        import termios

        if self.real < 0:
            return
        with suppress(OSError):  # the app may have closed stdin, and its descriptor may be another file now
            if os.path.sameopenfile(self._input, self._stdin):
                os.dup2(self.real, self._stdin)
        os.close(self.real)
        self.real = -1
        self.pass_on(self._mode[6][termios.VEOF])
