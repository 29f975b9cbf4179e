"""A server that hangs up is known to be gone at once, whoever listens there next."""

from __future__ import annotations

import pytest

from drivers.coppeliasim.address import Address
from drivers.coppeliasim.connection import Connection
from robotcore.errors import BackendError
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.zmq import ZmqServer

VERY_LONG_S = 600.0


def connected_to(server: ZmqServer) -> Connection:
    return Connection.open(Address(port=server.port), VERY_LONG_S)


def test_server_that_is_gone_is_not_waited_for() -> None:
    with ZmqServer(Simulator()) as server:
        connection = connected_to(server)
        assert connection.sim("getSimulationTime") == 0
    with pytest.raises(BackendError, match=r"is gone; it died or was closed in sim\.getSimulationTime"):
        connection.sim("getSimulationTime")
    connection.close()


def test_server_that_was_started_again_is_not_taken_for_the_one_before() -> None:
    with ZmqServer(Simulator()) as server:
        connection = connected_to(server)
    with ZmqServer(Simulator(), server.port), pytest.raises(BackendError, match="is gone"):
        connection.sim("getSimulationTime")
    connection.close()
