"""The address of a CoppeliaSim server: a check of what listens there, and the errors that name the address."""

from __future__ import annotations

import socket

from pydantic import Field

from robotcore.description import StrictModel
from robotcore.errors import BackendError

GREETING_S = 3.0
"""Time limit of the greeting after a connection was accepted."""

ZEROMQ = b"\xff"
"""The first byte of the greeting that a ZeroMQ server sends to each new client.

Source: "signature" in https://rfc.zeromq.org/spec/23. A server of the legacy remote API sends nothing before it has
received a message.
"""

_CONNECT_S = 0.3


class Address(StrictModel):
    """The host and port of a CoppeliaSim server.

    >>> str(Address(port=23010))
    '127.0.0.1:23010'
    """

    host: str = "127.0.0.1"
    port: int = Field(default=23000, ge=1, le=65535)

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def is_listening(address: Address) -> bool:
    """Return whether a server accepts connections at the address."""
    try:
        socket.create_connection((address.host, address.port), _CONNECT_S).close()
    except OSError:
        return False
    return True


def require_greeting(address: Address) -> None:
    """Raise BackendError unless a ZeroMQ server listens at the address.

    Each ZeroMQ server sends a greeting to a new client.
    """
    try:
        greeting = read_greeting(address)
    except OSError as error:
        raise connection_refused(address, error) from error
    if greeting != ZEROMQ:
        raise wrong_protocol(address, greeting)


def read_greeting(address: Address) -> bytes | None:
    """Connect to the address, and return the first byte that the server sends.

    Returns b"" if the server closes the connection, and None if it sends nothing within `GREETING_S`.
    Raises OSError if no connection is possible.
    """
    with socket.create_connection((address.host, address.port), _CONNECT_S) as connection:
        connection.settimeout(GREETING_S)
        try:
            return connection.recv(1)
        except TimeoutError:
            return None
        except ConnectionError:
            return b""


def connection_refused(address: Address, cause: OSError) -> BackendError:
    """Return the error for an address without a server."""
    reason = "" if isinstance(cause, ConnectionRefusedError) else f" ({cause.strerror or cause})"
    return BackendError(
        f"coppeliasim: no server listens at {address}{reason}. Start CoppeliaSim, or name its address with --host and "
        "--port",
        kind="connection-refused",
        address=str(address),
    )


def wrong_protocol(address: Address, greeting: bytes | None) -> BackendError:
    """Return the error for a server that sends no ZeroMQ greeting.

    greeting: the result of `read_greeting`.
    """
    if greeting is None:
        answer = "sends no ZeroMQ greeting"
    elif greeting:
        answer = f"begins with the byte {greeting.hex()} instead of a ZeroMQ greeting"
    else:
        answer = "hangs up instead of a ZeroMQ greeting"
    return BackendError(
        f"coppeliasim: the server at {address} {answer}: another program uses this port, or CoppeliaSim is frozen. "
        "Name CoppeliaSim's port with --port (its default is 23000). If this is the legacy remote API, use "
        "--backend vrep",
        kind="wrong-protocol",
        address=str(address),
    )


def server_gone(address: Address, function: str) -> BackendError:
    """Return the error for a server that ended before it answered the call of a function."""
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} ended during {function}. Start it again, and run again",
        kind="server-gone",
        address=str(address),
        function=function,
    )


def timed_out(address: Address, function: str, limit_s: float, *, is_known: bool) -> BackendError:
    """Return the error for a call that the server has not answered in time.

    limit_s: the time limit of the call, in seconds.
    is_known: whether the server has answered earlier calls.
    """
    advice = (
        "Check whether it shows a dialogue or hangs. If it is only slow, raise safety.answer_s in the robot's file"
        if is_known
        else "Check whether CoppeliaSim shows a dialogue or is busy"
    )
    return BackendError(
        f"coppeliasim: {address} has not answered {function} for {limit_s:.1f} s. {advice}",
        kind="timeout",
        address=str(address),
        function=function,
        limit_s=limit_s,
    )


def unexpected_answer(address: Address, function: str, answer: object) -> BackendError:
    """Return the error for an answer that a CoppeliaSim server never sends.

    answer: a description of the answer.
    """
    return BackendError(
        f"coppeliasim: {address} answered {function} with {answer}; CoppeliaSim's ZeroMQ remote API does not. "
        "Check which program listens there, and name CoppeliaSim's port with --port",
        kind="unexpected-answer",
        address=str(address),
        function=function,
    )


def server_too_old(address: Address) -> BackendError:
    """Return the error for a server that uses the first protocol of the remote API."""
    return BackendError(
        f"coppeliasim: {address} uses the first protocol of the ZeroMQ remote API, as CoppeliaSim up to 4.5 does. "
        "Install CoppeliaSim 4.6 or newer, or use --backend vrep",
        kind="server-too-old",
        address=str(address),
    )


def function_missing(address: Address, function: str) -> BackendError:
    """Return the error for a function that the server lacks, under its present and its older name."""
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} has no {function}. Install a newer one; this driver was tested "
        "with 4.10",
        kind="function-missing",
        address=str(address),
        function=function,
    )
