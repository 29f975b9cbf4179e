"""What fails for a while, once or again and again: the loop, the connection to the robot."""

from __future__ import annotations

from math import inf
from typing import Annotated

from pydantic import Field, model_validator

from robotcore.clock import Clock
from robotcore.devices import Motor, SampleT, Sensor
from robotcore.errors import DeviceError
from robotcore.faults.clocks import Stalling
from robotcore.faults.fault import ROUNDING_S, Duration, Fault, Kind
from robotcore.faults.occasion import Occasion
from robotcore.layers.layer import Layer
from robotcore.layers.over import MotorOver
from robotcore.layers.readers import Reader

Pause = Annotated[float, Field(ge=0.001, le=60, description="seconds")]


class Outage(Fault):
    """Fails for ``value`` seconds, and again ``every`` so many; ``lasts`` bounds when it may begin again."""

    value: Duration
    every: Duration | None = None

    @model_validator(mode="after")
    def _has_an_end(self) -> Outage:
        if self.every is not None and self.every <= self.value:
            raise ValueError(f"every={self.every:g} comes before the end of {self.value:g} seconds; take it longer")
        return self


class Stall(Outage):
    """Holds the loop up for so long; time goes on without a tick, and the deadman cuts."""

    on = frozenset({Kind.LOOP})
    example = "loop stall=0.3 after=5 every=10"

    value: Pause

    def layer(self, occasion: Occasion) -> StalledLoop:
        return StalledLoop(self)


class Lost(Outage):
    """Cuts every motor and sensor off for so long; a stop is tried all the same."""

    on = frozenset({Kind.CONNECTION})
    example = "connection lost=2 after=10"

    def layer(self, occasion: Occasion) -> CutOff:
        return CutOff(self, occasion.clock)

    def is_out(self, time: float) -> bool:
        """Return whether nothing can be reached at a time."""
        since = time + ROUNDING_S - self.after
        began = since - since % self.every if self.every else 0.0
        return since >= 0 and began < (self.lasts or inf) and since - began < self.value


class StalledLoop(Layer):
    """Lets the loop sleep longer than it wants."""

    def __init__(self, fault: Stall) -> None:
        self._fault = fault

    def clock(self, clock: Clock) -> Clock:
        fault = self._fault
        return Stalling(clock, fault.value, fault.after, fault.every or inf, fault.after + (fault.lasts or inf))


class CutOff(Layer):
    """Lets no sample and no command through while the connection is lost."""

    def __init__(self, fault: Lost, clock: Clock) -> None:
        self._fault, self._clock = fault, clock

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        def reached() -> SampleT:
            self.require(sensor.name)
            return read()

        return reached

    def motor(self, motor: Motor) -> Motor:
        return _Distant(motor, self)

    def require(self, device: str) -> None:
        """Raise DeviceError by the device's name while it cannot be reached."""
        if self._fault.is_out(self._clock.now()):
            raise DeviceError(device, "the connection is lost, by a fault on purpose")


class _Distant(MotorOver):
    """A motor that may not be reached."""

    def __init__(self, inner: Motor, connection: CutOff) -> None:
        super().__init__(inner)
        self._connection = connection

    def _apply(self, rad_s: float) -> None:
        self._connection.require(self.name)
        self._inner.set_velocity(rad_s)
