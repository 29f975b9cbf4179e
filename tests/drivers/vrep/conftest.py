from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest

from drivers.vrep import simx
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scenes import rover_scene


@pytest.fixture
def simulator() -> Simulator:
    return rover_scene(180)


@pytest.fixture
def server(simulator: Simulator) -> Iterator[LegacyServer]:
    with LegacyServer(simulator) as server:
        yield server


@pytest.fixture(autouse=True)
def _finish_clients() -> Iterator[None]:
    yield
    simx.simxFinish(-1)


@pytest.fixture
def unused_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return int(listening.getsockname()[1])
