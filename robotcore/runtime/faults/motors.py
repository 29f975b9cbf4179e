"""Motors that do not turn as they are told, and do not know. A stop is a stop whatever the fault."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from typing import Annotated

from pydantic import Field

from robotcore.hal.clock import Clock
from robotcore.hal.devices import Motor
from robotcore.runtime.faults.base import Fault, FaultContext, Kind, TickEndClock
from robotcore.runtime.layers.base import Layer, MotorWrapper
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
    """Turns this many times as fast as it is told."""

    on = _MOTORS
    example = "left_motor weak=0.6"

    value: Gain

    def layer(self, context: FaultContext) -> MotorGainLayer:
        return MotorGainLayer(self, context.clock, self.value)


class Reversed(Fault):
    """Turns the wrong way, as one whose wires were swapped."""

    on = _MOTORS
    example = "left_motor reversed"

    def layer(self, context: FaultContext) -> MotorGainLayer:
        return MotorGainLayer(self, context.clock, -1.0)


class MotorGainLayer(Layer):
    """Turns motors ``gain`` times as fast as they are told while ``fault`` is there.

    Where it comes or goes while a command lives, the command is told anew at the end of the tick.
    """

    def __init__(self, fault: Fault, clock: Clock, gain: float) -> None:
        self._fault, self._clock, self._gain = fault, clock, gain
        self._motors: list[FaultyMotor] = []

    def motor(self, motor: Motor) -> Motor:
        faulty = FaultyMotor(motor, self._gain_now)
        self._motors.append(faulty)
        return faulty

    def clock(self, clock: Clock) -> Clock:
        return TickEndClock(clock, self._end_tick)

    def _gain_now(self) -> float:
        return self._gain if self._fault.is_on(self._clock.now()) else 1.0

    def _end_tick(self) -> None:
        for motor in self._motors:
            motor.renew()


class FaultyMotor(MotorWrapper):
    """A motor that turns ``gain()`` times as fast as it is told; a deadman may stop it from another thread."""

    def __init__(self, inner: Motor, gain: Callable[[], float]) -> None:
        super().__init__(inner)
        self._gain = gain
        self._asked = self._command = 0.0
        self._stops = 0
        self._lock = RLock()

    def stop(self) -> None:
        with TimedLock(self._lock):
            self._stops += 1
            self._asked = self._command = 0.0
            super().stop()

    def renew(self) -> None:
        """Tell the motor what it was told last where the gain has changed since."""
        with self._lock:
            if self._gain() * self._asked != self._command:
                self._tell()

    def _apply(self, rad_s: float) -> None:
        with self._lock:
            self._asked = rad_s
            self._tell()

    def _tell(self) -> None:
        """Tell the motor; where it was stopped meanwhile, past a lock that nobody let go, stop it again."""
        stops = self._stops
        self._command = self._gain() * self._asked
        self._inner.set_velocity(self._command)
        if self._stops != stops:
            self.stop()
