"""Faults of motors: dead, weak, reversed. A faulty motor reports no error, and always obeys a stop."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from typing import Annotated

from pydantic import Field

from robotcore.hal.clock import Clock
from robotcore.runtime.faults.base import Fault, FaultContext, TargetKind, TickEndClock
from robotcore.runtime.layers.base import Layer, MotorOutput
from robotcore.safety.deadman import TimedLock

Gain = Annotated[float, Field(ge=0, le=1, description="gain")]


class MotorFault(Fault):
    """The base class of the faults of motors. ``gain`` multiplies the commanded velocities."""

    on = frozenset({TargetKind.MOTOR})

    @property
    def gain(self) -> float:
        """The factor of the commanded velocities."""
        return 0.0

    def layer(self, context: FaultContext) -> MotorGainLayer:
        return MotorGainLayer(self, context.clock)


class Dead(MotorFault):
    """A motor does not turn."""

    example = "right_motor dead after=10"


class Weak(MotorFault):
    """A motor turns at the given share of the commanded velocity."""

    example = "left_motor weak=0.6"

    value: Gain

    @property
    def gain(self) -> float:
        return self.value


class Reversed(MotorFault):
    """A motor turns in the wrong direction, as if its wires were swapped."""

    example = "left_motor reversed"

    @property
    def gain(self) -> float:
        return -1.0


class MotorGainLayer(Layer):
    """Multiplies the commanded velocities of motors by the gain of ``fault`` while it is active.

    If the fault begins or ends while a motor turns, the layer sends the last command again at the end of the tick.
    """

    def __init__(self, fault: MotorFault, clock: Clock) -> None:
        self._fault, self._clock = fault, clock
        self._motors: list[FaultyMotor] = []

    def motor(self, motor: MotorOutput) -> MotorOutput:
        faulty = FaultyMotor(motor, self._gain_now)
        self._motors.append(faulty)
        return MotorOutput(motor.name, faulty.set_velocity, faulty.stop)

    def clock(self, clock: Clock) -> Clock:
        return TickEndClock(clock, self._end_tick)

    def _gain_now(self) -> float:
        return self._fault.gain if self._fault.is_on(self._clock.now()) else 1.0

    def _end_tick(self) -> None:
        for motor in self._motors:
            motor.renew()


class FaultyMotor:
    """Sends each velocity to a motor, multiplied by the present result of ``gain()``.

    It has a lock, because the deadman may call `stop` from another thread.
    """

    def __init__(self, motor: MotorOutput, gain: Callable[[], float]) -> None:
        self._motor, self._gain = motor, gain
        self._asked = self._command = 0.0
        self._stops = 0
        self._lock = RLock()

    def set_velocity(self, rad_s: float) -> float:
        """Send ``gain()`` times a velocity in rad/s. Return the velocity without the gain.

        A real motor does not report its own weakness either.
        """
        with self._lock:
            self._asked = rad_s
            self._send()
        return rad_s

    def stop(self) -> None:
        """Stop the motor at once."""
        with TimedLock(self._lock):
            self._stops += 1
            self._asked = self._command = 0.0
            self._motor.stop()

    def renew(self) -> None:
        """Send the last velocity again if the gain has changed since then."""
        with self._lock:
            if self._gain() * self._asked != self._command:
                self._send()

    def _send(self) -> None:
        """Send the velocity. If another thread stopped the motor during the call, stop the motor again.

        A stop waits only a limited time for the lock. So a stop is possible during this call.
        """
        stops = self._stops
        self._command = self._gain() * self._asked
        self._motor.set_velocity(self._command)
        if self._stops != stops:
            self.stop()
