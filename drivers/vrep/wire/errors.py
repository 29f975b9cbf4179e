"""What can go wrong between this program and a simulator, as one tree.

BackendError
└── RemoteApiError                          whatever goes wrong on the line
    ├── NobodyListensError (ConnectionError)    nothing serves that port
    ├── ServerLostError (ConnectionError)       it hung up
    ├── ServerHangsError (TimeoutError)         it has not answered in time
    ├── GarbledReplyError (ValueError)          it answered what no server of this API answers
    ├── SimulationHaltedError                   the simulation is stopped or paused: its time does not pass
    └── RefusedError                            it could not do what it was asked for
"""

from __future__ import annotations

from robotcore.errors import BackendError


class RemoteApiError(BackendError):
    """A simulator cannot be reached, or not be understood, over the legacy remote API."""


class NobodyListensError(RemoteApiError, ConnectionError):
    """Nothing listens at that address."""


class ServerLostError(RemoteApiError, ConnectionError):
    """The server closed the connection."""


class ServerHangsError(RemoteApiError, TimeoutError):
    """The server has not answered in time."""


class GarbledReplyError(RemoteApiError, ValueError):
    """The bytes that came are no reply of this API."""

    def __init__(self, fault: str) -> None:
        super().__init__(
            f"that is no reply of the legacy remote API: {fault}. Look which program listens at this port: 19997 is "
            "the usual one, another is told in the simulator's remoteApiConnections.txt"
        )


class SimulationHaltedError(RemoteApiError):
    """The simulation is stopped or paused, so that no step can be taken."""


class RefusedError(RemoteApiError):
    """The server could not do what it was asked for."""
