"""What a child process does with its life: calls, one after another, as they come through a pipe."""

from __future__ import annotations

import os
import pickle
import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from typing import NoReturn

from robotcore.errors import RobotcoreError
from robotcore.sweep.reply import write_reply
from robotcore.sweep.supervisor import supervise
from robotcore.sweep.worker import prepare


def serve(handle: int) -> NoReturn:
    """Make this process ready, say so, and do what comes through the pipe until its other end is closed."""
    supervise(handle)
    sys.stdout = sys.stderr  # line by line: what waits in a buffer is lost with the process
    prepare()
    connection, calls = Connection(handle), SimpleQueue[bytes]()
    _keep_to_this_process(connection)
    Thread(target=_listen, args=(connection, calls), daemon=True).start()
    with suppress(OSError):  # nobody is there any more, or this is a copy that an app has made of the process
        _send(connection, write_reply("ready"))
        while True:
            _send(connection, _reply(calls.get()))
    os._exit(1)


def _send(connection: Connection, line: bytes) -> None:
    while line:
        line = line[os.write(connection.fileno(), line) :]


def _keep_to_this_process(connection: Connection) -> None:
    """Let nothing that an app starts hold the pipe open, which would hide the end of this process, or answer for it."""
    os.set_inheritable(connection.fileno(), False)
    os.register_at_fork(after_in_child=connection.close)


def _listen(connection: Connection, calls: SimpleQueue[bytes]) -> None:
    """Hear at once, in the middle of a call too, that nobody is there any more."""
    try:
        while True:
            calls.put(connection.recv_bytes())
    except (EOFError, OSError):
        os._exit(1)


def _reply(call: bytes) -> bytes:
    """Return what a call came to, a result or an error, as a line."""
    try:
        function, arguments = pickle.loads(call)  # noqa: S301  from the parent of this process
        return write_reply(function(*arguments))
    except RobotcoreError as error:
        return _encode_error(error)
    except Exception as error:  # noqa: BLE001  whatever it is, and what JSON cannot hold
        return write_reply(error=RobotcoreError(f"{type(error).__name__}: {error}"))


def _encode_error(error: RobotcoreError) -> bytes:
    try:
        return write_reply(error=error)
    except (TypeError, ValueError):  # an attribute that JSON cannot hold
        return write_reply(error=RobotcoreError(str(error)))
