"""How the guardian makes the wheels of a simulation stand that goes on by itself."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.vrep.connection import Connection
from drivers.vrep.wire import requests
from drivers.vrep.wire.errors import NobodyListensError, RemoteApiError, ServerHangsError
from drivers.vrep.wire.link import RETRY_S
from robotcore.hal.cutoff import Cutoff, Unconfirmed
from robotcore.hal.wall_clock import MonotonicClock

SHORT_S = 0.2
"""A guardian does not wait long; a server that listens and is free answers in milliseconds."""

DEAF_S = 0.75
"""A server hangs up on everyone, or does not listen, for half a second after its client was killed; all is tried again
so long, for a guardian is to have stopped everything within one. One that hangs is not: its app is to end soon."""


class StopJoints(Cutoff):
    """Gives joints the target velocity zero, over a connection of its own.

    A port serves one program at a time: it is free when the app's process has ended. A server that is gone, hangs, or
    still has the app, is told of, and no failure: the wheels of a simulation hurt nobody.
    """

    def __init__(self, host: str, port: int, joints: Sequence[int]) -> None:
        self._host, self._port, self._joints = host, port, joints

    def open(self) -> None:
        """Take nothing: the port is the app's."""

    def stop(self) -> str | None:
        clock = MonotonicClock()
        while True:
            try:
                self._stand()
            except RemoteApiError as failure:
                if isinstance(failure, ServerHangsError) or clock.now() + RETRY_S > DEAF_S:
                    return self._unconfirmed(failure)
            else:
                return None
            clock.sleep_until(clock.now() + RETRY_S)

    def close(self) -> None:
        """Give back nothing."""

    def _stand(self) -> None:
        with Connection.to(self._host, self._port, SHORT_S, patience_s=0.0) as connection:
            for joint in self._joints:
                connection.set(requests.joint_target_velocity(joint, 0.0))
            connection.call(requests.CLOCK)  # all that was set is done when this is answered

    def _unconfirmed(self, failure: RemoteApiError) -> Unconfirmed:
        if isinstance(failure, NobodyListensError):
            gone = f"nobody listens at {self._host}:{self._port} any more; where the simulator is gone, nothing turns"
            return Unconfirmed(gone)
        return Unconfirmed(f"simulated wheels may turn on: {failure}")
