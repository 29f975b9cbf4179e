"""The errors of the legacy remote API. Each inherits BackendError, and some a built-in error too."""

from __future__ import annotations

from robotcore.errors import BackendError


class RemoteApiError(BackendError):
    """An error of the connection to a simulator, or of a request to it."""

    kind = "remote-api"


class NoServerError(RemoteApiError, ConnectionError):
    """No server listens at the address."""

    kind = "no-server"


class ServerLostError(RemoteApiError, ConnectionError):
    """The server closed the connection."""

    kind = "server-lost"


class ServerTimeoutError(RemoteApiError, TimeoutError):
    """The server has not answered in time."""

    kind = "timeout"


class ProtocolError(RemoteApiError, ValueError):
    """The server sent bytes that are not a reply of this API."""

    kind = "invalid-reply"

    def __init__(self, problem: str) -> None:
        super().__init__(
            f"invalid reply of the legacy remote API: {problem}. Check which program listens at this port: the default "
            "is 19997, and the simulator's remoteApiConnections.txt names others",
            fault=problem,
        )


class SimulationHaltedError(RemoteApiError):
    """The simulation is stopped or paused, so that its time does not advance."""

    kind = "simulation-halted"


class RefusedError(RemoteApiError):
    """The server could not execute a request."""

    kind = "refused"
