"""Where the legacy remote API listens that is tried, and how apps and the rover come into the scene behind it."""

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
from tests.system.checking import address_in
from tests.system.speed import scaled

VARIABLE = "ROBOTCORE_VREP"
ANSWER_S = 3.0
"""On the reference machine: a simulator that draws without a graphics card may take long."""

WAIT = simx.simx_opmode_blocking


def address() -> Address | None:
    """Return where it listens, as the environment says; None where it says nothing."""
    return address_in(VARIABLE)


def known() -> Address:
    """Return where it listens, of which the environment has to tell."""
    found = address()
    assert found, f"set {VARIABLE}"
    return found


def options(**more: Any) -> dict[str, Any]:
    """Return the options that lead there."""
    return {"host": known().host, "port": known().port, "answer_s": scaled(ANSWER_S), **more}


def opened(*devices: str, **more: Any) -> Robot:
    """Join the rover of the scene, with these of its devices."""
    return VrepBackend().open(Setup(load_robot("rover"), None, frozenset(devices), 20.0, options=options(**more)))


def run_on(app: str, *observers: Observer, duration_s: float = 0.5, more: dict[str, Any] | None = None) -> RunResult:
    """Run an app of the camera's in the scene for so long."""
    asked = RunRequest(app, "vrep", settings={"duration_s": duration_s}, options=options(**more or {}))
    return run(asked, observers)


@contextmanager
def client() -> Iterator[int]:
    """Start a client of the official binding's names; the server has answered it."""
    number = simx.simxStart(known().host, known().port, True, True, 5000, 5)
    assert number >= 0
    assert simx.simxGetPingTime(number)[0] == simx.simx_return_ok
    try:
        yield number
    finally:
        simx.simxFinish(number)


def is_running(number: int) -> bool:
    """Return whether the simulation runs, as the newest that the server has said."""
    simx.simxGetPingTime(number)
    code, state = simx.simxGetInMessageInfo(number, simx.simx_headeroffset_server_state)
    assert code == 1
    return bool(state & 1)


def handle_of(number: int, name: str) -> int:
    """Return the handle of what has to be there."""
    code, handle = simx.simxGetObjectHandle(number, name, WAIT)
    assert code == simx.simx_return_ok, name
    return int(handle)


def as_bytes(pixels: Sequence[int]) -> bytes:
    """Return the binding's signed numbers as they were."""
    return bytes(value & 0xFF for value in pixels)
