"""Motor boards: what their pins are set to makes a simulator's wheels turn.

A line that lets a board sleep is not wired: no driver claims it, and it counts as high.
"""

from __future__ import annotations

from collections.abc import Callable

from drivers.raspberrypi.virtual.pins import VirtualPin
from robotcore.hal.devices import Motor

Velocity = Callable[[float], float]
"""What a motor turns at, in rad/s, at a duty from -1 to 1."""


def wire_two_inputs(
    motor: Motor, velocity: Velocity, forward: VirtualPin, backward: VirtualPin, enable: VirtualPin | None = None
) -> None:
    """Put an H-bridge on an input for each direction, both alike brake, and perhaps one that lets it work."""

    def duty() -> float:
        return float(forward.state) - float(backward.state) if enable is None or enable.state else 0.0

    _turn_by(duty, motor, velocity, *(pin for pin in (forward, backward, enable) if pin is not None))


def wire_phase_and_enable(motor: Motor, velocity: Velocity, phase: VirtualPin, enable: VirtualPin) -> None:
    """Put an H-bridge on an input for the duty, and one that is high to go backward."""
    _turn_by(lambda: float(-enable.state if phase.state else enable.state), motor, velocity, phase, enable)


def _turn_by(duty: Callable[[], float], motor: Motor, velocity: Velocity, *pins: VirtualPin) -> None:
    """Turn a motor by what its pins ask for, as soon as one of them changes."""
    for pin in pins:
        pin.on_change(lambda: motor.set_velocity(velocity(duty())))
