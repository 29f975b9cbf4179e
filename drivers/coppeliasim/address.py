"""The address of a CoppeliaSim, the greeting of the server there, and the errors that name the address."""

from __future__ import annotations

import socket

from pydantic import Field

from robotcore.description import StrictModel
from robotcore.errors import BackendError


def _require_greeting(address: Address) -> None:
    """Raise BackendError where nobody listens, or who listens does not begin as ZeroMQ does."""
    try:
        said = read_greeting(address)
    except OSError as error:
        raise connection_refused(address, error) from error
    if said != ZEROMQ:
        raise wrong_protocol(address, said)


_PROBE_S = 0.3

GREETING_S = 3.0
"""How long who has taken a connection may take to greet."""

ZEROMQ = b"\xff"
"""With which a server of ZeroMQ begins, at once and unasked, however busy its program is
(https://rfc.zeromq.org/spec/23, the signature). The legacy remote API's servers wait to be asked.
"""


class Address(StrictModel):
    """Where a CoppeliaSim listens."""

    host: str = "127.0.0.1"
    port: int = Field(default=23000, ge=1, le=65535)

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def is_listening(address: Address) -> bool:
    """Return whether anybody takes connections there."""
    try:
        socket.create_connection((address.host, address.port), _PROBE_S).close()
    except OSError:
        return False
    return True


def read_greeting(address: Address) -> bytes | None:
    """Return the first byte of a server's; none where it hangs up, None where nothing comes. Raises OSError."""
    with socket.create_connection((address.host, address.port), _PROBE_S) as line:
        line.settimeout(GREETING_S)
        try:
            return line.recv(1)
        except TimeoutError:
            return None
        except ConnectionError:
            return b""


def connection_refused(address: Address, why: OSError) -> BackendError:
    """Return the error for an address where there is no server."""
    reason = "" if isinstance(why, ConnectionRefusedError) else f" ({why.strerror or why})"
    return BackendError(
        f"coppeliasim: nobody listens at {address}{reason}. Start CoppeliaSim, or name where it runs with --host and "
        "--port",
        kind="connection-refused",
        address=str(address),
    )


def wrong_protocol(address: Address, said: bytes | None) -> BackendError:
    """Return the error for a server that greets otherwise than ZeroMQ, None being not at all."""
    spoken = f"begins with the byte {said.hex()}" if said else "hangs up"
    does = "says nothing" if said is None else spoken
    return BackendError(
        f"coppeliasim: who listens at {address} {does}; that is not CoppeliaSim's ZeroMQ remote API, or it is frozen. "
        "The legacy remote API is --backend vrep; else look which program listens there, and name the right port with "
        "--port: 23000 as CoppeliaSim is shipped",
        kind="wrong-protocol",
        address=str(address),
    )


def server_gone(address: Address, function: str) -> BackendError:
    """Return the error for a server that has ended during a call."""
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} is gone; it died or was closed in {function}. "
        "Start it again, and run again",
        kind="server-gone",
        address=str(address),
        function=function,
    )


def timed_out(address: Address, function: str, limit_s: float, *, is_known: bool) -> BackendError:
    """Return the error for a server that lets wait; one that ``is_known`` has answered before."""
    advice = (
        "Look whether it shows a dialogue or hangs; where it is only slow, raise safety.answer_s in the robot's "
        "description"
        if is_known
        else "Look whether a dialogue of CoppeliaSim's waits for somebody, or it is busy"
    )
    return BackendError(
        f"coppeliasim: {address} has not answered {function} for {limit_s:.1f} s. {advice}",
        kind="timeout",
        address=str(address),
        function=function,
        limit_s=limit_s,
    )


def unexpected_answer(address: Address, function: str, what: object) -> BackendError:
    """Return the error for an answer that is none of this protocol."""
    return BackendError(
        f"coppeliasim: {address} answered {function} with {what}; that is not CoppeliaSim's ZeroMQ remote API. "
        "Look which program listens there, and name the right one with --port",
        kind="unexpected-answer",
        address=str(address),
        function=function,
    )


def server_too_old(address: Address) -> BackendError:
    """Return the error for a server of the first protocol."""
    return BackendError(
        f"coppeliasim: {address} speaks the first protocol of the ZeroMQ remote API, as CoppeliaSim up to 4.5 does. "
        "Install CoppeliaSim 4.6 or newer, or use --backend vrep",
        kind="server-too-old",
        address=str(address),
    )


def function_missing(address: Address, function: str) -> BackendError:
    """Return the error for a function that a server does not offer, nor an older one that does the same."""
    return BackendError(
        f"coppeliasim: the CoppeliaSim at {address} has no {function}. Install a newer one; 4.10 is what this was "
        "made with",
        kind="function-missing",
        address=str(address),
        function=function,
    )
