"""Starts Python processes that are linked to this one by a socket, and that get no signals of the terminal.

On POSIX the process inherits one of a pair of sockets. Windows has no such inheritance. There the process connects to
this one over the loopback interface, and sends the secret that it has read from its standard input.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from socket import IPPROTO_TCP, TCP_NODELAY, create_connection, create_server, socket, socketpair
from subprocess import DEVNULL, PIPE, Popen
from threading import Timer
from typing import Any

from robotcore.system import HAS_POSIX, LOOPBACK

CONNECTING_S = 20.0
"""The time limit for the connection of a new process on a system without POSIX, in seconds."""

_POLL_S = 0.1
_CLOSED = -1
_LAST_STREAM = 2
_SECRET_BYTES = 32


def build_session_options(handles: Sequence[int] = (), *, is_detached: bool = False) -> dict[str, Any]:
    """Return the arguments of `Popen` with which Ctrl-C in the terminal does not reach the process.

    handles: the file descriptors that the process inherits. Only a system with POSIX can pass them on.
    is_detached: whether the process also continues after the window of its console was closed. On POSIX every such
        process does. On Windows it then writes nothing on the console.
    """
    if HAS_POSIX:
        return {"pass_fds": tuple(handles), "start_new_session": True}
    flag = "CREATE_NO_WINDOW" if is_detached else "CREATE_NEW_PROCESS_GROUP"
    return {"creationflags": getattr(subprocess, flag, 0)}


def start_linked_process(
    code: str, arguments: Sequence[str] = (), *, stdout: int, is_detached: bool = False
) -> tuple[Popen[bytes], socket]:
    """Start a Python process, and return it with this process's end of their link. Its standard input is empty.

    code: the code of the process. It opens its end with ``receive_link(sys.argv[1])``.
    arguments: the further arguments of the process, in ``sys.argv[2:]``.
    stdout: the standard output of the process, as in `Popen`.
    is_detached: see `build_session_options`.

    On POSIX the function does not wait. On another system it waits until the process has connected. If the process ends
    before, or does not connect within `CONNECTING_S`, the link is at its end.

    Raises OSError if the system refuses the process.
    """
    command = [sys.executable, "-c", code]
    if HAS_POSIX:
        ours, theirs = map(_move_above_streams, socketpair())
        with theirs:
            address = theirs.fileno()
            options = build_session_options([address])
            try:
                return Popen([*command, str(address), *arguments], stdin=DEVNULL, stdout=stdout, **options), ours  # noqa: S603  the Python that runs this
            except BaseException:
                ours.close()
                raise
    with create_server((LOOPBACK, 0)) as listener:
        address = listener.getsockname()[1]
        options = build_session_options(is_detached=is_detached)
        process = Popen([*command, f"{LOOPBACK}:{address}", *arguments], stdin=PIPE, stdout=stdout, **options)  # noqa: S603  the same
        try:
            return process, _accept(listener, process)
        except BaseException:
            process.kill()
            process.wait()
            raise


def _move_above_streams(link: socket) -> socket:
    """Return the same socket with a number above those of the standard streams, which a process may have closed."""
    if link.fileno() > _LAST_STREAM:
        return link
    import fcntl

    with link:
        return socket(fileno=fcntl.fcntl(link.fileno(), fcntl.F_DUPFD_CLOEXEC, _LAST_STREAM + 1))


def receive_link(address: str) -> socket:
    """Return this process's end of the link to the process that has started it.

    address: the first argument of this process.

    Raises OSError if the other process has ended.
    """
    host, colon, port = address.rpartition(":")
    if not colon:
        link = socket(fileno=int(address))
        link.set_inheritable(False)  # a child process must not keep it open
        return link
    secret = sys.stdin.buffer.read(_SECRET_BYTES)
    link = create_connection((host, int(port)))
    link.setsockopt(IPPROTO_TCP, TCP_NODELAY, 1)
    link.sendall(secret)
    return link


def _accept(listener: socket, process: Popen[bytes]) -> socket:
    """Return the connection of the process. Connections of other programs are closed."""
    secret = os.urandom(_SECRET_BYTES)
    assert process.stdin
    with suppress(OSError), process.stdin as pipe:  # the process may have ended
        pipe.write(secret)
    listener.settimeout(_POLL_S)
    limit = Timer(CONNECTING_S, listener.close)
    limit.daemon = True
    limit.start()
    try:
        while process.poll() is None and listener.fileno() != _CLOSED:
            with suppress(OSError):
                link = listener.accept()[0]
                if _has_secret(link, secret):
                    link.settimeout(None)
                    link.setsockopt(IPPROTO_TCP, TCP_NODELAY, 1)
                    return link
                link.close()
    finally:
        limit.cancel()
    process.kill()
    ours, theirs = socketpair()
    theirs.close()
    return ours


def _has_secret(link: socket, secret: bytes) -> bool:
    from hmac import compare_digest

    received = b""
    link.settimeout(_POLL_S)
    with suppress(OSError):
        while len(received) < len(secret) and (more := link.recv(len(secret) - len(received))):
            received += more
    return compare_digest(received, secret)
