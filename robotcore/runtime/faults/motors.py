"""Faults of motors: dead, weak, reversed. The motors do not report them, and a stop always works."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from typing import Annotated

from pydantic import Field

from robotcore.hal.clock import Clock
from robotcore.runtime.faults.base import Fault, FaultContext, Kind, TickEndClock
from robotcore.runtime.layers.base import Layer, MotorOutput
from robotcore.safety.deadman import TimedLock

Gain = Annotated[float, Field(ge=0, le=1, description="gain")]

_MOTORS = frozenset({Kind.MOTOR})


class Dead(Fault):
    """Does not turn."""

    on = _MOTORS
    example = "right_motor dead after=10"

    def layer(self, context: FaultContext) -> MotorGainLayer:
        return MotorGainLayer(self, context.clock, 0.0)


class Weak(Fault):
    """Turns at this share of the commanded velocity."""

    on = _MOTORS
    example = "left_motor weak=0.6"

    value: Gain

    def layer(self, context: FaultContext) -> MotorGainLayer:
        return MotorGainLayer(self, context.clock, self.value)


class Reversed(Fault):
    """Turns the wrong way, like a motor with swapped wires."""

    on = _MOTORS
    example = "left_motor reversed"

    def layer(self, context: FaultContext) -> MotorGainLayer:
        return MotorGainLayer(self, context.clock, -1.0)


class MotorGainLayer(Layer):
    """Multiplies velocities by ``gain`` while ``fault`` is active.

    If the fault begins or ends while a command is in force, the command is sent again at the end of the tick.
    """

    def __init__(self, fault: Fault, clock: Clock, gain: float) -> None:
        self._fault, self._clock, self._gain = fault, clock, gain
        self._motors: list[FaultyMotor] = []

    def motor(self, motor: MotorOutput) -> MotorOutput:
        faulty = FaultyMotor(motor, self._gain_now)
        self._motors.append(faulty)
        return MotorOutput(motor.name, faulty.set_velocity, faulty.stop)

    def clock(self, clock: Clock) -> Clock:
        return TickEndClock(clock, self._end_tick)

    def _gain_now(self) -> float:
        return self._gain if self._fault.is_on(self._clock.now()) else 1.0

    def _end_tick(self) -> None:
        for motor in self._motors:
            motor.renew()


class FaultyMotor:
    """Sends ``gain()`` times each velocity to a motor. A deadman may stop the motor from another thread."""

    def __init__(self, motor: MotorOutput, gain: Callable[[], float]) -> None:
        self._motor, self._gain = motor, gain
        self._asked = self._command = 0.0
        self._stops = 0
        self._lock = RLock()

    def set_velocity(self, rad_s: float) -> float:
        """Send a velocity in rad/s; return it without the gain, as a motor without the fault would."""
        with self._lock:
            self._asked = rad_s
            self._send()
        return rad_s

    def stop(self) -> None:
        """Stop the motor."""
        with TimedLock(self._lock):
            self._stops += 1
            self._asked = self._command = 0.0
            self._motor.stop()

    def renew(self) -> None:
        """Send the last velocity again if the gain has changed since."""
        with self._lock:
            if self._gain() * self._asked != self._command:
                self._send()

    def _send(self) -> None:
        """Send the velocity. If a stop came meanwhile, because its wait for the lock timed out, stop again."""
        stops = self._stops
        self._command = self._gain() * self._asked
        self._motor.set_velocity(self._command)
        if self._stops != stops:
            self.stop()
