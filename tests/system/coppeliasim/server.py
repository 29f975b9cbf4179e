"""The CoppeliaSim under test: its address, and robots in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from drivers.coppeliasim.address import Address
from drivers.coppeliasim.backend import CoppeliaSimBackend
from drivers.coppeliasim.connection import SimulatorConnection
from robotcore.description import RobotDescription, WorldDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from tests.system.checking import read_address
from tests.system.speed import scaled

VARIABLE = "ROBOTCORE_COPPELIASIM"
ANSWER_S = 3.0
"""The time limit of a call, in seconds. It is long, because rendering without a graphics card is slow."""


def address() -> Address | None:
    """Return the address in the environment variable ROBOTCORE_COPPELIASIM; None if it is not set."""
    return read_address(VARIABLE)


def options(**more: Any) -> dict[str, Any]:
    """Return the options of the backend for this simulator."""
    found = address()
    assert found, f"set {VARIABLE}"
    return {"host": found.host, "port": found.port, "answer_s": scaled(ANSWER_S), **more}


def open_robot(
    world: WorldDescription, *devices: str, robot: RobotDescription | None = None, rate_hz: float = 20.0, **more: Any
) -> Robot:
    """Open devices of a robot, by default all devices of the rover."""
    described = robot or load_robot("rover")
    names = frozenset(devices or (device.name for device in described.devices))
    return CoppeliaSimBackend().open(Setup(described, world, names, rate_hz, options=options(**more)))


@contextmanager
def connect() -> Iterator[SimulatorConnection]:
    """Yield a second connection to the simulator."""
    found = address()
    assert found
    connection = SimulatorConnection.open(found, scaled(ANSWER_S))
    try:
        yield connection
    finally:
        connection.close()
