"""How the guardian makes the wheels of a simulation stand that goes on by itself."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep import requests
from drivers.vrep.connection import Connection
from robotcore.guardian import Cutoff


class StandingJoints(Cutoff):
    """Gives joints the target velocity zero, over a connection of its own.

    A port serves one program at a time: it is free when the app's process has ended. The one that lives and hangs is
    told: the wheels of a simulation hurt nobody.
    """

    def __init__(self, host: str, port: int, joints: Sequence[int], answer_s: float) -> None:
        self._host, self._port, self._joints, self._answer_s = host, port, joints, answer_s

    def open(self) -> None:
        """Take nothing: the port is the app's."""

    def stop(self) -> str | None:
        with Connection.to(self._host, self._port, self._answer_s) as connection:
            for joint in self._joints:
                connection.set(requests.joint_target_velocity(joint, 0.0))
        return None

    def close(self) -> None:
        """Give back nothing."""
