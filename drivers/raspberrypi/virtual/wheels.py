"""Motor boards: what their pins are set to makes a simulator's wheels turn."""

from __future__ import annotations

from collections.abc import Callable

from drivers.raspberrypi.virtual.pins import VirtualPin
from robotcore.devices import Motor

Velocity = Callable[[float], float]
"""What a motor turns at, in rad/s, at a duty from -1 to 1."""


class Board:
    """One channel of a motor board with its motor, which turns as soon as a pin changes.

    ``duty`` is what the ``pins`` ask for, and ``velocity`` what the motor makes of it. A line
    that puts the board to sleep is no pin of it: it counts as high.
    """

    def __init__(self, motor: Motor, velocity: Velocity, duty: Callable[[], float], *pins: VirtualPin) -> None:
        self._motor, self._velocity, self._duty = motor, velocity, duty
        for pin in pins:
            pin.on_change(self._turn)

    def _turn(self) -> None:
        self._motor.set_velocity(self._velocity(self._duty()))


def two_inputs(
    motor: Motor, velocity: Velocity, forward: VirtualPin, backward: VirtualPin, enable: VirtualPin | None = None
) -> Board:
    """Return an H-bridge with an input for each direction, both alike brake, and perhaps one that lets it work."""

    def duty() -> float:
        return float(forward.state) - float(backward.state) if enable is None or enable.state else 0.0

    return Board(motor, velocity, duty, *(pin for pin in (forward, backward, enable) if pin is not None))


def phase_and_enable(motor: Motor, velocity: Velocity, phase: VirtualPin, enable: VirtualPin) -> Board:
    """Return an H-bridge with an input for the duty, and one that is high to go backward."""
    return Board(motor, velocity, lambda: float(-enable.state if phase.state else enable.state), phase, enable)
