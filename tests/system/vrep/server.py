"""The legacy remote API under test: its address, and apps and robots in its scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from drivers.coppeliasim.address import Address
from drivers.vrep import simx
from drivers.vrep.backend import VrepBackend
from robotcore.description import load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Observer, run
from tests.system.checking import read_address
from tests.system.speed import scaled

VARIABLE = "ROBOTCORE_VREP"
ANSWER_S = 3.0
"""The time limit of a call, in seconds. It is long, because rendering without a graphics card is slow."""

WAIT = simx.simx_opmode_blocking


def address() -> Address | None:
    """Return the address in the environment variable ROBOTCORE_VREP; None if it is not set."""
    return read_address(VARIABLE)


def require_address() -> Address:
    """Return the address in the environment variable ROBOTCORE_VREP."""
    found = address()
    assert found, f"set {VARIABLE}"
    return found


def options(**more: Any) -> dict[str, Any]:
    """Return the options of the backend for this simulator."""
    return {"host": require_address().host, "port": require_address().port, "answer_s": scaled(ANSWER_S), **more}


def open_rover(*devices: str, **more: Any) -> Robot:
    """Open devices of the rover in the scene."""
    return VrepBackend().open(Setup(load_robot("rover"), None, frozenset(devices), 20.0, options=options(**more)))


def run_on(app: str, *observers: Observer, duration_s: float = 0.5, more: dict[str, Any] | None = None) -> RunResult:
    """Run an app in the scene.

    duration_s: its duration in simulated seconds.
    more: further options of the backend.
    """
    request = RunRequest(app, "vrep", settings={"duration_s": duration_s}, options=options(**more or {}))
    return run(request, observers)


@contextmanager
def start_client() -> Iterator[int]:
    """Start a client of `drivers.vrep.simx`, and wait for the server's first answer."""
    number = simx.simxStart(require_address().host, require_address().port, True, True, 5000, 5)
    assert number >= 0
    assert simx.simxGetPingTime(number)[0] == simx.simx_return_ok
    try:
        yield number
    finally:
        simx.simxFinish(number)


def is_running(number: int) -> bool:
    """Return whether the simulation runs."""
    simx.simxGetPingTime(number)
    code, state = simx.simxGetInMessageInfo(number, simx.simx_headeroffset_server_state)
    assert code == 1
    return bool(state & 1)


def find_handle(number: int, name: str) -> int:
    """Return the handle of an object. The check fails if there is no such object."""
    code, handle = simx.simxGetObjectHandle(number, name, WAIT)
    assert code == simx.simx_return_ok, name
    return int(handle)


def to_bytes(pixels: Sequence[int]) -> bytes:
    """Convert the binding's signed numbers to bytes."""
    return bytes(value & 0xFF for value in pixels)
