"""The built-in simulator as a server: ``python -m tests.faraway.server`` prints its port and serves one run.

A request is a tuple of an action and its arguments. The answer is the action's result.
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
    """Receive a setup, open its robot, and answer requests until the connection closes."""
    setup: Setup = connection.recv()
    with KinematicBackend().open(replace(setup, options={})) as robot:
        actions = build_actions(robot)
        while True:
            action, *arguments = connection.recv()
            connection.send(actions[action](*arguments))


def build_actions(robot: Robot) -> dict[str, Callable[..., Any]]:
    """Return the actions of the server by name."""

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

    return {"read": read, "turn": turn, "advance": advance, "truth": read_truth}


if __name__ == "__main__":
    main()
