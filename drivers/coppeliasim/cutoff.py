"""The cutoff by which the guardian stops wheels in a scene after the program was killed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from robotcore.hal.cutoff import Cutoff, Unconfirmed

SHORT_S = 0.3
"""Time limit of each call; an idle server answers in milliseconds."""

IDLE_S = 5.0


class StopJoints(Cutoff):
    """Sets the target velocity of joints to zero, over a connection of its own.

    joints: the handles of the joints.

    If the server has ended or hangs, `stop` returns a report and raises no error, because simulated wheels do no harm.
    """

    def __init__(self, host: str, port: int, joints: Sequence[int]) -> None:
        self._host, self._port, self._joints = host, port, joints

    def open(self) -> None:
        """Import the client. It connects only in `stop`, because the server drops clients that send nothing."""
        import drivers.coppeliasim.client  # noqa: F401

    def stop(self) -> str | None:
        from drivers.coppeliasim.client import CallRefused, CallTimeout, Client, Disconnected, ProtocolViolation

        client = Client(self._host, self._port, IDLE_S)
        try:
            client.ask("zmqRemoteApi.require", ["sim"], SHORT_S)
            for joint in self._joints:
                with suppress(CallRefused):  # the joint was removed
                    client.ask("sim.setJointTargetVelocity", [joint, 0.0], SHORT_S)
            client.ask("_*end*_", [], SHORT_S)
        except (CallTimeout, Disconnected, CallRefused, ProtocolViolation):
            return Unconfirmed(f"{self._host}:{self._port} does not answer. If the simulator has ended, no wheel turns")
        finally:
            client.close()
        return None

    def close(self) -> None:
        """Do nothing: `stop` keeps no connection."""
