"""The address of a CoppeliaSim server, a check of the server's protocol, and the errors that name the address."""

from __future__ import annotations

import socket

from pydantic import Field

from robotcore.description import StrictModel
from robotcore.errors import BackendError

GREETING_S = 3.0
"""The time within which a server must send its greeting after it has accepted a connection, in seconds."""

ZEROMQ = b"\xff"
"""The first byte of the greeting that a ZeroMQ server sends to each new client.

Source: "signature" in https://rfc.zeromq.org/spec/23. A server of the legacy remote API sends no greeting.
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
    """Connect to the address, and raise BackendError unless the server sends the greeting of ZeroMQ."""
    try:
        greeting = read_greeting(address)
    except OSError as error:
        raise build_refused_error(address, error) from error
    if greeting != ZEROMQ:
        raise build_protocol_error(address, greeting)


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


def build_refused_error(address: Address, cause: OSError) -> BackendError:
    """Return the error for an address at which no server listens.

    cause: the error of the operating system.
    """
    reason = "" if isinstance(cause, ConnectionRefusedError) else f" ({cause.strerror or cause})"
    return BackendError(
        f"coppeliasim: no server listens at {address}{reason}. Start CoppeliaSim, or name its address with --host and "
        "--port",
        kind="connection-refused",
        address=str(address),
    )


def build_protocol_error(address: Address, greeting: bytes | None) -> BackendError:
    """Return the error for a server that does not send the greeting of ZeroMQ.

    greeting: the result of `read_greeting`.
    """
    if greeting is None:
        answer = "sends no ZeroMQ greeting"
    elif greeting:
        answer = f"begins with the byte {greeting.hex()} instead of a ZeroMQ greeting"
    else:
        answer = "closes the connection instead of a ZeroMQ greeting"
    return BackendError(
        f"coppeliasim: the server at {address} {answer}: another program uses this port, or CoppeliaSim is frozen. "
        "Name CoppeliaSim's port with --port (its default is 23000), or use --backend vrep for the legacy remote API",
        kind="wrong-protocol",
        address=str(address),
    )


def build_server_gone_error(address: Address, function: str) -> BackendError:
    """Return the error for a server that has ended during a call.

    function: the name of the called function.
    """
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} ended during {function}. Start CoppeliaSim, and run again",
        kind="server-gone",
        address=str(address),
        function=function,
    )


def build_timeout_error(address: Address, function: str, limit_s: float, *, is_known: bool) -> BackendError:
    """Return the error for a call that the server has not answered in time.

    function: the name of the called function.
    limit_s: the time limit of the call, in seconds.
    is_known: whether the server has answered earlier calls.
    """
    advice = (
        "Check whether CoppeliaSim shows a dialogue or hangs. If it is only slow, raise safety.answer_s in the robot's "
        "file"
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


def build_answer_error(address: Address, function: str, answer: object) -> BackendError:
    """Return the error for an answer that no CoppeliaSim server sends.

    function: the name of the called function.
    answer: the text that describes the answer in the error message.
    """
    return BackendError(
        f"coppeliasim: {address} answered {function} with {answer}, which is not an answer of CoppeliaSim's ZeroMQ "
        "remote API. Check which program listens at this port, and name CoppeliaSim's port with --port",
        kind="unexpected-answer",
        address=str(address),
        function=function,
    )


def build_too_old_error(address: Address) -> BackendError:
    """Return the error for a server whose protocol is the first one of the ZeroMQ remote API."""
    return BackendError(
        f"coppeliasim: {address} uses the first protocol of the ZeroMQ remote API, as CoppeliaSim up to 4.5 does. "
        "Install CoppeliaSim 4.6 or newer, or use --backend vrep",
        kind="server-too-old",
        address=str(address),
    )


def build_missing_error(address: Address, function: str) -> BackendError:
    """Return the error for a server that does not have a function or constant."""
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} has no {function}. Install a newer one; this driver was tested "
        "with 4.10",
        kind="function-missing",
        address=str(address),
        function=function,
    )
