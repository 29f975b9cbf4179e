"""Faults that occur once or repeatedly, each time for a limited time: a stalled loop, a lost device or connection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import floor, inf
from typing import Annotated, Any, ParamSpec, TypeVar

from pydantic import Field, model_validator

from robotcore.errors import DeviceLostError
from robotcore.hal.clock import Clock, ClockWrapper
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.runtime.faults.base import ROUNDING_S, Duration, Fault, FaultContext
from robotcore.runtime.faults.targets import ConnectionTarget, LoopTarget
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader, Send

P = ParamSpec("P")
T = TypeVar("T")
Pause = Annotated[float, Field(ge=0.001, le=60, description="seconds")]


class Outage(Fault):
    """The base class of faults that occur once or repeatedly, each time for ``value`` seconds.

    The first outage begins at the time ``after``. If ``every`` is set, another one begins every ``every`` seconds. With
    ``lasts``, no outage begins later than ``lasts`` seconds after the first one.
    """

    value: Duration
    every: Duration | None = None

    @model_validator(mode="after")
    def _require_consistent_times(self) -> Outage:
        if self.every is None and self.lasts is not None:
            raise ValueError(
                f"lasts={self.lasts:g} needs every=SECONDS, because it ends a repeated fault. "
                f"Add every, or leave lasts out for one fault of {self.value:g} seconds"
            )
        if self.every is not None and self.every <= self.value:
            raise ValueError(
                f"every={self.every:g} is too short for a fault of {self.value:g} seconds. "
                f"Raise every above {self.value:g}"
            )
        return self

    def is_active(self, time: float) -> bool:
        """Return whether an outage is active at ``time``, in seconds on the robot's clock."""
        since = time + ROUNDING_S - self.after
        began = floor(since / self.every) * self.every if self.every else 0.0
        return since >= 0 and began < (self.lasts or inf) - ROUNDING_S and since - began < self.value


class Stall(Outage):
    """The loop stalls for the given time. Time passes without a tick, and the deadman stops the motors."""

    target_classes = (LoopTarget,)
    example = "loop stall=0.3 after=5 every=10"

    value: Pause

    def layer(self, context: FaultContext) -> LoopStallLayer:
        return LoopStallLayer(self)


class LostDevice(Outage):
    """Devices are disconnected for the given time. Each call of such a device fails, except the stop of a motor."""

    target_classes = (Sensor, Actuator, ConnectionTarget)
    example = "connection lost=2 after=10"

    def layer(self, context: FaultContext) -> ConnectionLossLayer:
        return ConnectionLossLayer(self, context)


class LoopStallLayer(Layer):
    """Makes the sleeps of the loop longer while the fault is active."""

    def __init__(self, fault: Stall) -> None:
        self._fault = fault

    def clock(self, clock: Clock) -> Clock:
        return StallingClock(clock, self._fault)


class StallingClock(ClockWrapper):
    """A clock that stalls the loop: the first sleep in each outage of ``fault`` lasts at least as long as the outage.

    The callbacks of `call_at` are called during a stall too.
    """

    def __init__(self, source: Clock, fault: Stall) -> None:
        super().__init__(source)
        self._stall, self._due, self._every = fault.value, fault.after, fault.every or inf
        self._end = fault.after + (fault.lasts or inf)

    def sleep_until(self, deadline: float) -> bool:
        now = self.now() + ROUNDING_S
        if not self._due <= now < self._end:
            return super().sleep_until(deadline)
        while self._due <= now:
            self._due += self._every
        awake = now - ROUNDING_S + self._stall
        return super().sleep_until(max(deadline, awake)) and awake <= deadline


class ConnectionLossLayer(Layer):
    """Raises DeviceLostError in the calls of sensors and actuators while the fault is active.

    The stop of a motor still reaches the driver.
    """

    def __init__(self, fault: LostDevice, context: FaultContext) -> None:
        self._fault, self._context = fault, context

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return self._fail_while_lost(sensor.name, read)

    def motor(self, motor: MotorOutput) -> MotorOutput:
        return replace(motor, set_velocity=self._fail_while_lost(motor.name, motor.set_velocity))

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        return self._fail_while_lost(actuator.name, send)

    def _fail_while_lost(self, device: str, function: Callable[P, T]) -> Callable[P, T]:
        written = self._context.spec

        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            if self._fault.is_active(self._context.clock.now()):
                text = f'is disconnected by the fault "{written}"'
                raise DeviceLostError(device, text, kind="injected-loss", fault=written)
            return function(*args, **kwargs)

        return call
