"""Where a CoppeliaSim is to be found."""

from __future__ import annotations

import socket

from pydantic import Field

from robotcore.description import StrictModel

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


def listens(address: Address) -> bool:
    """Return whether anybody takes connections there."""
    try:
        socket.create_connection((address.host, address.port), _PROBE_S).close()
    except OSError:
        return False
    return True


def greeting(address: Address) -> bytes | None:
    """Return the first byte of a server's; none where it hangs up, None where nothing comes. Raises OSError."""
    with socket.create_connection((address.host, address.port), _PROBE_S) as line:
        line.settimeout(GREETING_S)
        try:
            return line.recv(1)
        except TimeoutError:
            return None
        except ConnectionError:
            return b""
