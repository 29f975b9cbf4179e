"""How the guardian makes wheels stand in a scene whose time goes on when our program has been killed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from robotcore.hal.cutoff import Cutoff, Unconfirmed

SHORT_S = 0.3
"""A guardian does not wait long; a server that is free answers in milliseconds."""

IDLE_S = 5.0


class StopJoints(Cutoff):
    """Gives joints the target velocity zero, over a connection of its own, which a server has for many at a time.

    A server that is gone, or hangs, is told of, and no failure: the wheels of a simulation hurt nobody.
    """

    def __init__(self, host: str, port: int, joints: Sequence[int]) -> None:
        self._host, self._port, self._joints = host, port, joints

    def open(self) -> None:
        """Load what `stop` needs, and take nothing: a client that says nothing is forgotten."""
        import drivers.coppeliasim.client  # noqa: F401

    def stop(self) -> str | None:
        from drivers.coppeliasim.client import CallRefused, CallTimeout, Client, Disconnected, ProtocolViolation

        client = Client(self._host, self._port, IDLE_S)
        try:
            client.ask("zmqRemoteApi.require", ["sim"], SHORT_S)
            for joint in self._joints:
                with suppress(CallRefused):  # of a joint that is there no more
                    client.ask("sim.setJointTargetVelocity", [joint, 0.0], SHORT_S)
            client.ask("_*end*_", [], SHORT_S)
        except (CallTimeout, Disconnected, CallRefused, ProtocolViolation):
            return Unconfirmed(f"{self._host}:{self._port} does not answer; where the simulator is gone, nothing turns")
        finally:
            client.close()
        return None

    def close(self) -> None:
        """Give back nothing."""
