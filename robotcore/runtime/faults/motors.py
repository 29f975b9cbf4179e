"""Faults of motors: dead, weak, reversed. A faulty motor reports no error, and always obeys a stop.

A fault that begins or ends takes effect with the next command, at the latest after one lease of the deadman.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from pydantic import Field

from robotcore.hal.clock import Clock
from robotcore.kinds.motor import Motor
from robotcore.runtime.faults.base import Fault, FaultContext
from robotcore.runtime.layers.base import Layer, MotorOutput

Gain = Annotated[float, Field(ge=0, le=1, description="gain")]


class MotorFault(Fault):
    """The base class of the faults of motors. ``gain`` multiplies the commanded velocities."""

    target_classes = (Motor,)

    @property
    def gain(self) -> float:
        """The factor of the commanded velocities."""
        return 0.0

    def layer(self, context: FaultContext) -> MotorGainLayer:
        return MotorGainLayer(self, context.clock)


class DeadMotor(MotorFault):
    """A motor does not turn."""

    example = "right_motor dead after=10"


class WeakMotor(MotorFault):
    """A motor turns at the given share of the commanded velocity."""

    example = "left_motor weak=0.6"

    value: Gain

    @property
    def gain(self) -> float:
        return self.value


class ReversedMotor(MotorFault):
    """A motor turns in the wrong direction, as if its wires were swapped."""

    example = "left_motor reversed"

    @property
    def gain(self) -> float:
        return -1.0


class MotorGainLayer(Layer):
    """Multiplies the commanded velocities of motors by the gain of ``fault`` while it is active."""

    def __init__(self, fault: MotorFault, clock: Clock) -> None:
        self._fault, self._clock = fault, clock

    def motor(self, motor: MotorOutput) -> MotorOutput:
        """Return an output that returns the velocity without the gain, as a weak motor does not report its weakness."""

        def set_velocity(rad_s: float) -> float:
            motor.set_velocity(self._fault.gain * rad_s if self._fault.is_active(self._clock.now()) else rad_s)
            return rad_s

        return replace(motor, set_velocity=set_velocity)
