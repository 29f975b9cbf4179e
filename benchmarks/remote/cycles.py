"""The cycle of a robot through a backend: two motor commands, a time step, a range and a picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import cycle as endless

from drivers.vrep import simx
from robotcore.hal.backend import Setup, load_backend

Cycle = Callable[[], object]

SPEED_RAD_S = 0.5
DEVICES = ("left_motor", "right_motor", "nose", "eye")


@contextmanager
def open_backend_cycle(backend: str, setup: Setup) -> Iterator[Cycle]:
    """Open a robot without layers, and yield a function that executes its cycle."""
    with load_backend(backend).open(setup) as robot:
        left, right = (robot.motors[name] for name in DEVICES[:2])
        clock, turns = robot.clock, iterate_speeds()

        def cycle() -> object:
            forward, backward = next(turns)
            left.set_velocity(forward)
            right.set_velocity(backward)
            clock.sleep_until(clock.now() + 1 / setup.rate_hz)
            return robot.range.read().distance, robot.camera.read().image

        yield cycle


def iterate_speeds() -> Iterator[tuple[float, float]]:
    """Yield new wheel speeds for each cycle in rad/s, because a driver need not send unchanged speeds."""
    return endless(((SPEED_RAD_S, -SPEED_RAD_S), (-SPEED_RAD_S, SPEED_RAD_S)))


@contextmanager
def open_stepped_picture_cycle(setup: Setup) -> Iterator[Cycle]:
    """Open a cycle with a time step of V-REP and a picture."""
    with load_backend("vrep").open(replace(setup, devices=frozenset({"eye"}))) as robot:
        clock = robot.clock

        def picture() -> object:
            clock.sleep_until(clock.now() + 1 / setup.rate_hz)
            return robot.camera.read().image

        yield picture


@contextmanager
def open_blocking_picture_cycle(setup: Setup) -> Iterator[Cycle]:
    """Open a cycle that gets a picture by a blocking call, as a script does. The simulation runs in real time."""
    client = simx.simxStart(setup.options["host"], setup.options["port"], True, True, 5000, 5)
    _, eye = simx.simxGetObjectHandle(client, "/rover/eye", simx.simx_opmode_blocking)
    simx.simxStartSimulation(client, simx.simx_opmode_blocking)
    try:
        yield partial(_pixels, client, eye)
    finally:
        simx.simxStopSimulation(client, simx.simx_opmode_blocking)
        while simx.simxGetInMessageInfo(client, simx.simx_headeroffset_server_state)[1]:
            simx.simxGetPingTime(client)
        simx.simxFinish(client)


def _pixels(client: int, eye: int) -> object:
    code, _, pixels = simx.simxGetVisionSensorImage(client, eye, 0, simx.simx_opmode_blocking)
    assert code == simx.simx_return_ok
    return pixels
