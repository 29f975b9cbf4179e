"""What fails for a while, once or again and again: the loop, a device, the connection to all of them."""

from __future__ import annotations

from math import floor, inf
from typing import Annotated

from pydantic import Field, model_validator

from robotcore.errors import DeviceLostError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Display, Image, Motor, SampleT, Sensor
from robotcore.runtime.faults.base import ROUNDING_S, Duration, Fault, FaultContext, Kind, StallingClock
from robotcore.runtime.layers.base import Layer, MotorWrapper, Reader

Pause = Annotated[float, Field(ge=0.001, le=60, description="seconds")]


class Outage(Fault):
    """Fails for ``value`` seconds, and again ``every`` so many; ``lasts`` bounds when it may begin again."""

    value: Duration
    every: Duration | None = None

    @model_validator(mode="after")
    def _fits_together(self) -> Outage:
        if self.every is None and self.lasts is not None:
            raise ValueError(
                f"lasts={self.lasts:g} is for how long it may begin again; say with every=SECONDS how often, "
                f"or leave it out: it fails for {self.value:g} seconds"
            )
        if self.every is not None and self.every <= self.value:
            raise ValueError(f"every={self.every:g} comes before the end of {self.value:g} seconds; take it longer")
        return self

    def is_on(self, time: float) -> bool:
        """Return whether one of the outages is there at a time."""
        since = time + ROUNDING_S - self.after
        began = floor(since / self.every) * self.every if self.every else 0.0
        return since >= 0 and began < (self.lasts or inf) - ROUNDING_S and since - began < self.value


class Stall(Outage):
    """Holds the loop up for so long; time goes on without a tick, and the deadman cuts."""

    on = frozenset({Kind.LOOP})
    example = "loop stall=0.3 after=5 every=10"

    value: Pause

    def layer(self, context: FaultContext) -> StalledLoop:
        return StalledLoop(self)


class Lost(Outage):
    """Cuts devices off for so long: whatever is asked of them fails; a stop is tried all the same."""

    on = frozenset(Kind) - {Kind.LOOP}
    example = "connection lost=2 after=10"

    def layer(self, context: FaultContext) -> ConnectionLoss:
        return ConnectionLoss(self, context)


class StalledLoop(Layer):
    """Lets the loop sleep longer than it wants."""

    def __init__(self, fault: Stall) -> None:
        self._fault = fault

    def clock(self, clock: Clock) -> Clock:
        fault = self._fault
        return StallingClock(clock, fault.value, fault.after, fault.every or inf, fault.after + (fault.lasts or inf))


class ConnectionLoss(Layer):
    """Lets no sample, no command and no picture through while the connection is lost."""

    def __init__(self, fault: Lost, context: FaultContext) -> None:
        self._fault, self._context = fault, context

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def reached() -> SampleT:
            self.require(sensor.name)
            return read()

        return reached

    def motor(self, motor: Motor) -> Motor:
        return _DistantMotor(motor, self)

    def display(self, display: Display) -> Display:
        return _DistantDisplay(display, self)

    def require(self, device: str) -> None:
        """Raise DeviceLostError by the device's name and the fault while it cannot be reached."""
        if self._fault.is_on(self._context.clock.now()):
            raise DeviceLostError(device, f'the connection is lost, by the fault "{self._context.written}"')


class _DistantMotor(MotorWrapper):
    """A motor that may not be reached."""

    def __init__(self, inner: Motor, connection: ConnectionLoss) -> None:
        super().__init__(inner)
        self._connection = connection

    def _apply(self, rad_s: float) -> None:
        self._connection.require(self.name)
        self._inner.set_velocity(rad_s)


class _DistantDisplay(Display):
    """A display that may not be reached."""

    def __init__(self, inner: Display, connection: ConnectionLoss) -> None:
        super().__init__(inner.name)
        self._inner, self._connection = inner, connection

    def _show(self, image: Image) -> None:
        self._connection.require(self.name)
        self._inner.show(image)

    def _release(self) -> None:
        self._inner.close()
