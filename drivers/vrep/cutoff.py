"""How the guardian makes the wheels of a simulation stand that goes on by itself."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep import requests
from drivers.vrep.connection import Connection
from drivers.vrep.errors import NobodyListensError, RemoteApiError
from robotcore.guardian import Cutoff

SHORT_S = 0.2
"""A guardian does not wait long; a server that listens and is free answers in milliseconds."""


class StandingJoints(Cutoff):
    """Gives joints the target velocity zero, over a connection of its own.

    A port serves one program at a time: it is free when the app's process has ended. Where nobody listens any more,
    nothing turns; a server that hangs, or still has the app, is told of: the wheels of a simulation hurt nobody.
    """

    def __init__(self, host: str, port: int, joints: Sequence[int]) -> None:
        self._host, self._port, self._joints = host, port, joints

    def open(self) -> None:
        """Take nothing: the port is the app's."""

    def stop(self) -> str | None:
        try:
            with Connection.to(self._host, self._port, SHORT_S) as connection:
                for joint in self._joints:
                    connection.set(requests.joint_target_velocity(joint, 0.0))
        except NobodyListensError:
            return None
        except RemoteApiError as failure:
            return f"simulated wheels may turn on: {failure}"
        return None

    def close(self) -> None:
        """Give back nothing."""
