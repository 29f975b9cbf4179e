"""The built-in simulator in a process of its own; ``python -m tests.faraway.server`` prints its port, serves one run.

A request is a tuple: what is to be done and with what; the answer is what it returned.
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
from robotcore.hal.devices import Motor, Sensor
from robotcore.hal.robot import Robot


def main() -> None:
    with Listener(("127.0.0.1", 0)) as listener:
        sys.stdout.write(f"{listener.address[1]}\n")
        sys.stdout.flush()
        with listener.accept() as connection, suppress(EOFError, ConnectionError):
            serve(connection)


def serve(connection: Connection[Any, Any]) -> None:
    """Open the robot that comes first, and do what is asked until nobody asks any more."""
    setup: Setup = connection.recv()
    with KinematicBackend().open(replace(setup, options={})) as robot:
        deeds = deeds_on(robot)
        while True:
            what, *arguments = connection.recv()
            connection.send(deeds[what](*arguments))


def deeds_on(robot: Robot) -> dict[str, Callable[..., Any]]:
    """Return what can be asked, by name."""

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

    def tell(what: str) -> object:
        return getattr(robot.truth, what)()

    return {"read": read, "turn": turn, "advance": advance, "tell": tell}


if __name__ == "__main__":
    main()
