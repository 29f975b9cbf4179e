"""The address of a CoppeliaSim server, a check of the server's protocol, and the errors that name the address."""

from __future__ import annotations

import socket
from typing import NamedTuple

from robotcore.errors import BackendError

GREETING_S = 3.0
"""The time within which a server must send its greeting after it has accepted a connection, in seconds."""

ZEROMQ = b"\xff"
"""The first byte of the greeting that a ZeroMQ server sends to each new client.

Source: "signature" in https://rfc.zeromq.org/spec/23. A server of the legacy remote API sends no greeting.
"""

_CONNECT_S = 0.3


class Address(NamedTuple):
    """The host and port of a CoppeliaSim server.

    >>> str(Address(port=23010))
    '127.0.0.1:23010'
    """

    host: str = "127.0.0.1"
    port: int = 23000

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


class RefusedError(BackendError):
    """The server answered a call with an error. The connection stays usable."""

    kind = "refused"


def build_error(address: Address, kind: str, problem: str, **fields: object) -> BackendError:
    """Return the error for a problem with the server at an address.

    problem: the text after the name of the backend.
    """
    return BackendError(f"coppeliasim: {problem}", kind=kind, address=str(address), **fields)


def build_answer_error(address: Address, function: str, answer: object) -> BackendError:
    """Return the error for an answer that no CoppeliaSim server sends.

    function: the name of the called function.
    answer: the text that describes the answer in the error message.
    """
    return build_error(
        address,
        "unexpected-answer",
        f"{address} answered {function} with {answer}, which is not an answer of CoppeliaSim's ZeroMQ remote API. "
        "Check which program listens at this port, and name CoppeliaSim's port with --port",
        function=function,
    )


def is_listening(address: Address) -> bool:
    """Return whether a server accepts connections at the address."""
    try:
        socket.create_connection((address.host, address.port), _CONNECT_S).close()
    except OSError:
        return False
    return True


def require_greeting(address: Address) -> None:
    """Connect to the address, and raise BackendError unless the server sends the greeting of ZeroMQ."""
    try:
        connection = socket.create_connection((address.host, address.port), _CONNECT_S)
    except OSError as error:
        reason = "" if isinstance(error, ConnectionRefusedError) else f" ({error.strerror or error})"
        raise build_error(
            address,
            "connection-refused",
            f"no server listens at {address}{reason}. Start CoppeliaSim, or name its address with --host and --port",
        ) from error
    with connection:
        connection.settimeout(GREETING_S)
        try:
            greeting = connection.recv(1)
        except OSError:
            greeting = b""
    if greeting != ZEROMQ:
        raise build_error(
            address,
            "wrong-protocol",
            f"the server at {address} sends no ZeroMQ greeting: another program uses this port, or CoppeliaSim is "
            "frozen. Name CoppeliaSim's port with --port (its default is 23000), or use --backend vrep for the legacy "
            "remote API",
        )
