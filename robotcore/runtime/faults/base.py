"""The base classes of injected faults: parameters, kinds of device, context, and layers that poll."""

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
    """The context of one fault in a run, with its random numbers.

    Seed, fault, device and time determine each number. So every run draws the same, however often an app reads.
    """

    clock: Clock
    """The clock of the robot."""
    seed: int
    """The seed of the run."""
    position: int
    """The position among the faults of the run."""
    written: str
    """The specification of the fault, for messages."""

    def random_at(self, device: str, time: float) -> Random:
        """Return the random generator of a device for a time in seconds."""
        return random_at(f"{self.seed}:{self._source(device)}", time)

    def noise(self, device: str, sigma: float) -> Noise:
        """Return normal noise of a device with the standard deviation ``sigma``."""
        return Noise(self.seed, self._source(device), sigma)

    def _source(self, device: str) -> str:
        return f"{device}:fault {self.position}"


ROUNDING_S = 1e-6
"""Times that differ by less are equal, because sums and quotients round them."""

LONGEST_S = 1e5
"""The latest time on a robot's clock."""


class Kind(str, Enum):
    """A kind of target that can fail."""

    CAMERA = "camera"
    RANGE = "range sensor"
    ENCODER = "encoder"
    BATTERY = "battery"
    MOTOR = "motor"
    DISPLAY = "display"
    LOOP = "loop"
    CONNECTION = "connection"


SENSORS = frozenset({Kind.CAMERA, Kind.RANGE, Kind.ENCODER, Kind.BATTERY})

Moment = Annotated[float, Field(ge=0, le=LONGEST_S, description="seconds")]
Duration = Annotated[float, Field(ge=0.001, le=LONGEST_S, description="seconds")]
Probability = Annotated[float, Field(ge=0, le=1, description="probability")]


class Fault(StrictModel):
    """The base class of faults. A fault can be on targets of the kinds ``on``; ``example`` is a specification of it.

    The fields are its parameters, each with its unit as ``description``. The field ``value`` is the value of the effect
    itself, as in ``drop=0.2``. A fault is active from ``after`` seconds on the robot's clock, for ``lasts`` seconds or
    to the end.
    """

    on: ClassVar[frozenset[Kind]] = frozenset()
    example: ClassVar[str] = ""

    after: Moment = 0.0
    lasts: Duration | None = None

    @abstractmethod
    def layer(self, context: FaultContext) -> Layer:
        """Return the layer that makes devices fail. It is put over the devices of the target only."""

    def is_on(self, time: float) -> bool:
        """Return whether the fault is active at a time in seconds."""
        return -ROUNDING_S <= time - self.after < (self.lasts or inf) - ROUNDING_S


class TickEndClock(ClockWrapper):
    """Calls ``end_tick`` at the end of each tick, just before time passes."""

    def __init__(self, source: Clock, end_tick: Callable[[], None]) -> None:
        super().__init__(source)
        self._end_tick = end_tick

    def sleep_until(self, deadline: float) -> bool:
        self._end_tick()
        return super().sleep_until(deadline)


class StallingClock(ClockWrapper):
    """Makes a sleep return ``stall`` seconds late, first at ``first``, then every ``every`` seconds.

    No stall begins at ``end`` or later. Time and due calls go on during a stall.
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
    """Reads its sensors in every tick: at the end of the tick, if no other part has read them."""

    def __init__(self) -> None:
        self._polled: list[PolledReader[Any]] = []

    def polled(self, read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a reader that is read in every tick."""
        polled = PolledReader(read)
        self._polled.append(polled)
        return polled

    def clock(self, clock: Clock) -> Clock:
        return TickEndClock(clock, self._end_tick)

    def _end_tick(self) -> None:
        for polled in self._polled:
            polled.end_tick()


class PolledReader(Generic[SampleT]):
    """Reads a sensor when it is called, and at the end of a tick without a call. The latter raises no DeviceError."""

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
