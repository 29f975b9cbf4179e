"""The cutoff with which the guardian stops the wheels of a scene over the legacy remote API."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep.connection import Connection
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import NoServerError, RemoteApiError
from robotcore.hal.cutoff import Cutoff, UnconfirmedStop

SHORT_S = 0.2
"""Time limit of a request, in seconds. An idle server answers in milliseconds."""

RETRY_FOR_S = 0.75
"""The time during which `StopJoints.stop` tries again to connect, in seconds.

For half a second after the app was killed, the server does not listen, or closes new connections. The guardian must
stop all motors within one second.
"""


class StopJoints(Cutoff):
    """Sets the target velocity of joints to zero, over a separate connection.

    host, port: the address of the server.
    joints: the handles of the joints.

    A port serves one program at a time. It becomes free when the app's process has ended. If the server does not
    answer, `stop` raises no error, because simulated wheels do no harm. It then returns an `UnconfirmedStop` message.
    """

    def __init__(self, host: str, port: int, joints: Sequence[int]) -> None:
        self._host, self._port, self._joints = host, port, joints

    def open(self) -> None:
        """Do nothing, because the port still serves the app."""

    def stop(self) -> str | None:
        try:
            with Connection.open(self._host, self._port, SHORT_S, RETRY_FOR_S) as connection:
                for joint in self._joints:
                    connection.post(requests.joint_target_velocity(joint, 0.0))
                connection.call(requests.CLOCK)  # its answer proves that the server has executed the commands
        except NoServerError:
            return UnconfirmedStop(
                f"no server listens at {self._host}:{self._port}. If the simulator has ended, no wheel turns"
            )
        except RemoteApiError as failure:
            return UnconfirmedStop(f"simulated wheels may still turn: {failure}")
        return None

    def close(self) -> None:
        """Do nothing, because `stop` has closed its connection."""
