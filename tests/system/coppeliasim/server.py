"""Where the CoppeliaSim listens that is tried, and how robots are opened in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from drivers.coppeliasim.address import Address
from drivers.coppeliasim.backend import CoppeliaSimBackend
from drivers.coppeliasim.connection import Connection
from robotcore.description import RobotDescription, WorldDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from tests.system.checking import address_in
from tests.system.speed import scaled

VARIABLE = "ROBOTCORE_COPPELIASIM"
ANSWER_S = 3.0
"""On the reference machine: a simulator that draws without a graphics card may take long."""


def address() -> Address | None:
    """Return where it listens, as the environment says; None where it says nothing."""
    return address_in(VARIABLE)


def options(**more: Any) -> dict[str, Any]:
    """Return the options that lead there."""
    found = address()
    assert found, f"set {VARIABLE}"
    return {"host": found.host, "port": found.port, "answer_s": scaled(ANSWER_S), **more}


def opened(
    world: WorldDescription, *devices: str, robot: RobotDescription | None = None, rate_hz: float = 20.0, **more: Any
) -> Robot:
    """Open a robot, by default the rover, with all its devices where none is named."""
    described = robot or load_robot("rover")
    names = frozenset(devices or (words.name for words in described.devices))
    return CoppeliaSimBackend().open(Setup(described, world, names, rate_hz, options=options(**more)))


@contextmanager
def looking() -> Iterator[Connection]:
    """Look at the simulator from aside."""
    found = address()
    assert found
    connection = Connection.open(found, scaled(ANSWER_S))
    try:
        yield connection
    finally:
        connection.close()
