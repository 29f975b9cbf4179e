"""The base classes of injected faults: parameters, kinds of target, context, and polling layers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from math import inf
from random import Random
from typing import Annotated, Any, ClassVar, Generic

from pydantic import Field

from robotcore.description import StrictModel
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock, ClockWrapper
from robotcore.hal.devices import SampleT
from robotcore.runtime.layers.base import Layer, Reader
from robotcore.runtime.layers.imperfections import Noise, random_at


@dataclass(frozen=True)
class FaultContext:
    """The context of one fault in a run. It provides the fault's random numbers.

    The seed, the fault, the device and the time determine each number. So the numbers do not depend on how many times
    an app reads a sensor.
    """

    clock: Clock
    """The clock of the robot."""
    seed: int
    """The seed of the run."""
    position: int
    """The position of the fault in the list of the run's faults, from 0."""
    spec: str
    """The specification of the fault, for messages."""

    def random_at(self, device: str, time: float) -> Random:
        """Return a random generator that is seeded by a device's name and a time in seconds."""
        return random_at(f"{self.seed}:{self._source(device)}", time)

    def noise(self, device: str, sigma: float) -> Noise:
        """Return the normally distributed noise of a device. ``sigma`` is its standard deviation."""
        return Noise(self.seed, self._source(device), sigma)

    def _source(self, device: str) -> str:
        return f"{device}:fault {self.position}"


ROUNDING_S = 1e-6
"""Times that differ by less count as equal, because sums and quotients have rounding errors. In seconds."""

MAX_TIME_S = 1e5
"""The largest time that a fault's parameter may have, in seconds on a robot's clock."""


class TargetKind(str, Enum):
    """A kind of target that a fault can affect."""

    CAMERA = "camera"
    RANGE = "range sensor"
    ENCODER = "encoder"
    BATTERY = "battery"
    MOTOR = "motor"
    DISPLAY = "display"
    LOOP = "loop"
    CONNECTION = "connection"


SENSORS = frozenset({TargetKind.CAMERA, TargetKind.RANGE, TargetKind.ENCODER, TargetKind.BATTERY})

Moment = Annotated[float, Field(ge=0, le=MAX_TIME_S, description="seconds")]
Duration = Annotated[float, Field(ge=0.001, le=MAX_TIME_S, description="seconds")]
Probability = Annotated[float, Field(ge=0, le=1, description="probability")]


class Fault(StrictModel):
    """The base class of faults. The fields of a subclass are the parameters of its fault.

    The ``description`` of a field is its unit. The field ``value`` is the value of the effect itself, as in
    ``drop=0.2``. A fault begins at ``after`` seconds on the robot's clock. It ends ``lasts`` seconds later, or with the
    run.

    on: the kinds of targets that the fault can affect.
    example: a specification of the fault.
    """

    on: ClassVar[frozenset[TargetKind]] = frozenset()
    example: ClassVar[str] = ""

    after: Moment = 0.0
    lasts: Duration | None = None

    @abstractmethod
    def layer(self, context: FaultContext) -> Layer:
        """Return the layer that makes devices fail. A run applies it to the target's devices and to the clock only."""

    def is_on(self, time: float) -> bool:
        """Return whether the fault is active at a time in seconds."""
        return -ROUNDING_S <= time - self.after < (self.lasts or inf) - ROUNDING_S


class TickEndClock(ClockWrapper):
    """A clock that calls ``end_tick`` at the end of each tick, just before time passes."""

    def __init__(self, source: Clock, end_tick: Callable[[], None]) -> None:
        super().__init__(source)
        self._end_tick = end_tick

    def sleep_until(self, deadline: float) -> bool:
        self._end_tick()
        return super().sleep_until(deadline)


class StallingClock(ClockWrapper):
    """A clock that stalls the loop: at set times, a sleep lasts at least ``stall`` seconds.

    The first stall begins at the time ``first``, and another one every ``every`` seconds. No stall begins at ``end`` or
    later. During a stall, time passes and due callbacks are called.
    """

    def __init__(self, source: Clock, stall: float, first: float, every: float, end: float) -> None:
        super().__init__(source)
        self._stall, self._due, self._every, self._end = stall, first, every, end

    def sleep_until(self, deadline: float) -> bool:
        now = self.now() + ROUNDING_S
        if not self._due <= now < self._end:
            return super().sleep_until(deadline)
        while self._due <= now:
            self._due += self._every
        awake = now - ROUNDING_S + self._stall
        return super().sleep_until(max(deadline, awake)) and awake <= deadline


class PollingLayer(Layer):
    """A layer that reads its sensors in every tick. It reads those that the app has not read at the end of the tick."""

    def __init__(self) -> None:
        self._polled: list[PolledReader[Any]] = []

    def poll(self, read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a function that reads like ``read``. The layer calls it in each tick in which no other part does."""
        polled = PolledReader(read)
        self._polled.append(polled)
        return polled

    def clock(self, clock: Clock) -> Clock:
        return TickEndClock(clock, self._end_tick)

    def _end_tick(self) -> None:
        for polled in self._polled:
            polled.end_tick()


class PolledReader(Generic[SampleT]):
    """Reads a sensor when it is called.

    In a tick without such a call, `end_tick` reads the sensor and ignores DeviceErrors.
    """

    def __init__(self, read: Reader[SampleT]) -> None:
        self._read = read
        self._was_read = False

    def __call__(self) -> SampleT:
        self._was_read = True
        return self._read()

    def end_tick(self) -> None:
        if not self._was_read:
            with suppress(DeviceError):
                self._read()
        self._was_read = False
