"""The kinematic simulator in its own process. ``python -m tests.external_simulator.server`` serves one run.

It prints its port first. A request is a tuple of a function's name and its arguments. The answer is the return value.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection, Listener
from typing import Any

from drivers.kinematic.backend import KinematicBackend
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Sensor
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import Motor


def main() -> None:
    with Listener(("127.0.0.1", 0)) as listener:
        sys.stdout.write(f"{listener.address[1]}\n")
        sys.stdout.flush()
        with listener.accept() as connection, suppress(EOFError, ConnectionError):
            serve(connection)


def serve(connection: Connection[Any, Any]) -> None:
    """Open the robot of the first message, then answer requests until the client disconnects."""
    setup: Setup = connection.recv()
    with KinematicBackend().open(replace(setup, options={})) as robot:
        functions = build_functions(robot)
        while True:
            name, *arguments = connection.recv()
            connection.send(functions[name](*arguments))


def build_functions(robot: Robot) -> dict[str, Callable[..., Any]]:
    """Return the functions that a client can call, by name."""

    def read(name: str) -> object:
        sensor = robot[name]
        assert isinstance(sensor, Sensor)
        return sensor.read()

    def turn(name: str, rad_s: float) -> float:
        motor = robot[name]
        assert isinstance(motor, Motor)
        return motor.set_velocity(rad_s)

    def advance(steps: int) -> None:
        clock = robot.clock
        assert isinstance(clock, SteppedClock)
        clock.sleep_until(clock.now() + steps * clock.step)

    def read_truth(name: str) -> object:
        return getattr(robot.truth, name)()

    return {"read": read, "turn": turn, "advance": advance, "read_truth": read_truth}


if __name__ == "__main__":
    main()
