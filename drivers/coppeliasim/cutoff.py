"""The cutoff with which the guardian stops the wheels of a CoppeliaSim scene after the program was killed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from drivers.coppeliasim.address import Address, RefusedError
from robotcore.errors import BackendError
from robotcore.hal.cutoff import Cutoff, UnconfirmedStop

SHORT_S = 0.3
"""Time limit of each call, in seconds. An idle server answers in milliseconds."""

IDLE_S = 5.0


class StopJoints(Cutoff):
    """Sets the target velocity of joints to zero, over a separate connection.

    host, port: the address of the server.
    joints: the handles of the joints.

    If the server has ended or hangs, `stop` raises no error, because simulated wheels do no harm. It then returns an
    `UnconfirmedStop` message.
    """

    def __init__(self, host: str, port: int, joints: Sequence[int]) -> None:
        self._host, self._port, self._joints = host, port, joints

    def open(self) -> None:
        """Import the client, so that `stop` need not import it.

        Only `stop` connects, because the server drops clients that make no calls.
        """
        import drivers.coppeliasim.client  # noqa: F401

    def stop(self) -> str | None:
        from drivers.coppeliasim.client import Client

        address = Address(host=self._host, port=self._port)
        client = Client(address, IDLE_S)
        try:
            client.call_within("zmqRemoteApi.require", ["sim"], SHORT_S)
            for joint in self._joints:
                with suppress(RefusedError):  # the joint was removed
                    client.call_within("sim.setJointTargetVelocity", [joint, 0.0], SHORT_S)
            client.call_within("_*end*_", [], SHORT_S)
        except BackendError as failure:
            if failure.kind == "server-gone":
                return UnconfirmedStop(f"no server listens at {address}. If the simulator has ended, no wheel turns")
            return UnconfirmedStop(f"simulated wheels may still turn: {failure}")
        finally:
            client.close()
        return None

    def close(self) -> None:
        """Do nothing, because `stop` has closed its connection."""
