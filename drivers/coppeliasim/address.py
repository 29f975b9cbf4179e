"""Where a CoppeliaSim is to be found."""

from __future__ import annotations

import socket

from pydantic import Field

from robotcore.description import Described

_PROBE_S = 0.3


class Address(Described):
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
