"""Starts and ends the process of the live page, and exchanges messages with it.

The page has its own process, so that no viewer can slow the loop of the run.
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import IO, Any

import numpy as np

from robotcore.child_process import build_session_options
from robotcore.errors import ResourceError
from robotcore.live.messages import Message
from robotcore.optics import Image
from robotcore.system import HAS_POSIX
from robotcore.threads import start_thread

CLOSING_S = 2.0
"""The longest wait for the end of the page's process, in seconds."""

MAX_SIDE_PX = 1280
"""A picture that is wider or higher is sent with every second, third, … row and column."""

MAX_ACTION_BYTES = 4096

HandleAction = Callable[[dict[str, Any]], None]
"""Executes an action of a viewer, such as ``{"type": "estop"}``. A thread calls it."""


class PageProcess:
    """Starts the process of the page, sends messages to it, and receives the actions of the viewers.

    listener: the socket at which the page listens.
    token: the token that a viewer needs; empty if the page needs none.
    hosts: the names by which a browser may reach the page, besides IP addresses.
    """

    def __init__(self, listener: socket.socket, token: str, hosts: list[str]) -> None:
        self._listener = listener
        self._settings = {"type": "settings", "token": token, "hosts": hosts}
        self._process: subprocess.Popen[bytes] | None = None
        self._reader: Thread | None = None

    def start(self, handle: HandleAction, report_end: Callable[[], None]) -> None:
        """Start the process. It outlives Ctrl-C in the terminal, so that the page can show the end of the run.

        report_end: a function that a thread calls when the process has ended, for any reason.

        Raises ResourceError if the operating system refuses the process or a thread.
        """
        handles = [self._listener.fileno()]
        place: int | tuple[str, int] = handles[0]
        if not HAS_POSIX:  # the process cannot inherit the socket, so it listens again at the same address
            place, handles = self._listener.getsockname()[:2], []
            self._listener.close()
        # Python's own folders come first, and that of the script or the app last. So no file of them replaces a module
        # of Python or of a package. A script named click.py would start a page that starts the script.
        folders = [*sys.path[1:], *sys.path[:1]]
        code = f"import sys; sys.path += {folders!r}; from robotcore.live.server import main; main({place!r})"
        try:
            self._process = subprocess.Popen(  # noqa: S603  the Python that runs this
                [sys.executable, "-I", "-S", "-c", code],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                **build_session_options(handles),
            )
        except OSError as error:
            raise ResourceError(f"the system refuses the process of the live page: {error.strerror}") from error
        self._listener.close()
        output = self._process.stdout
        assert output
        self._reader = start_thread(lambda: self._read_actions(output, handle, report_end), "live page actions")
        self.send(Message(self._settings))

    def send(self, message: Message) -> bool:
        """Send a message, and wait until the process has read it. Return False if the process has ended."""
        if self._process is None:
            return False
        pipe = self._process.stdin
        assert pipe
        try:
            pipe.write(message.pack())
            if len(message.picture):
                pipe.write(message.picture)
            pipe.flush()
        except (OSError, ValueError):  # ValueError: another thread has closed the pipe
            return False
        return True

    def close(self) -> None:
        """End the process, after it has sent all messages to the viewers. Later calls do nothing."""
        self._listener.close()
        if (process := self._process) is None:
            return
        self._process = None
        with suppress(OSError):
            assert process.stdin
            process.stdin.close()
        try:
            process.wait(CLOSING_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if self._reader:
            self._reader.join(CLOSING_S)
        assert process.stdout
        process.stdout.close()

    def kill(self) -> None:
        """End the process at once, so that a thread that waits in `send` continues."""
        if self._process:
            self._process.kill()

    @staticmethod
    def _read_actions(output: IO[bytes], handle: HandleAction, report_end: Callable[[], None]) -> None:
        while line := output.readline(MAX_ACTION_BYTES):
            with suppress(ValueError):  # a line that the process did not finish
                action = json.loads(line)
                if isinstance(action, dict):
                    handle(action)
        report_end()


def build_picture_message(name: str, image: Image) -> Message:
    """Return the message of a picture, with at most `MAX_SIDE_PX` pixels on each side."""
    step = -(-max(image.shape[:2]) // MAX_SIDE_PX)
    pixels = np.ascontiguousarray(image[::step, ::step])
    return Message({"type": "picture", "name": name, "shape": list(pixels.shape)}, pixels.data.cast("B"))
