"""The base classes of injected faults: parameters, context, and polling layers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from random import Random
from typing import Annotated, Any, ClassVar

from pydantic import Field

from robotcore.description import StrictModel
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock, ClockWrapper
from robotcore.hal.device import SampleT, Sensor
from robotcore.hal.noise import Noise, random_at
from robotcore.runtime.faults.targets import TargetClass
from robotcore.runtime.layers.base import Layer, Reader


@dataclass(frozen=True)
class FaultContext:
    """The data of one fault in a run, and the source of its random numbers.

    The seed, the fault, the device and the time determine each random number. The number of reads has no influence.

    >>> from robotcore.hal.clock import SteppedClock
    >>> context = FaultContext(SteppedClock(20, lambda steps: None), seed=7, position=0, spec="camera drop=0.2")
    >>> context.random_at("eye", 0.5).random() == context.random_at("eye", 0.5).random()
    True
    """

    clock: Clock
    """The clock of the robot."""
    seed: int
    """The seed of the run."""
    position: int
    """The index of the fault in the list of the run's faults, from 0."""
    spec: str
    """The specification of the fault, such as ``camera drop=0.2``, for messages."""

    def random_at(self, device: str, time: float) -> Random:
        """Return a random generator. Its seed is that of the run, the fault, a device's name and a time in seconds."""
        return random_at(f"{self.seed}:{self._source(device)}", time)

    def noise(self, device: str, sigma: float) -> Noise:
        """Return the normal noise of a device. ``sigma`` is its standard deviation."""
        return Noise(self.seed, self._source(device), sigma)

    def _source(self, device: str) -> str:
        return f"{device}:fault {self.position}"


ROUNDING_S = 1e-6
"""Two times count as equal if they differ by less than this, in seconds. Sums and quotients have rounding errors."""

MAX_TIME_S = 1e5
"""The largest value of a parameter that is a time or a duration, in seconds."""

Moment = Annotated[float, Field(ge=0, le=MAX_TIME_S, description="seconds")]
Duration = Annotated[float, Field(ge=0.001, le=MAX_TIME_S, description="seconds")]
Probability = Annotated[float, Field(ge=0, le=1, description="probability")]


class Fault(StrictModel):
    """The base class of faults. The fields of a subclass are the parameters of its fault.

    The ``description`` of a field is its unit. The field ``value`` is the value of the effect itself, such as 0.2 in
    ``drop=0.2``. The fault begins at ``after`` seconds on the robot's clock, and ends ``lasts`` seconds later. If
    ``lasts`` is None, it ends with the run.

    target_classes: the classes that the fault can affect: classes of devices such as Sensor or Motor, LoopTarget,
        ConnectionTarget.
    example: a specification of the fault.

    >>> from robotcore.kinds.motor import Motor
    >>> from robotcore.runtime.faults import FaultContext
    >>> from robotcore.runtime.faults.base import Probability
    >>> from robotcore.runtime.layers.base import Layer
    >>> class HotMotor(Fault):
    ...     target_classes = (Motor,)
    ...     example = "left_motor hot=0.5"
    ...     value: Probability
    ...
    ...     def layer(self, context: FaultContext) -> Layer:
    ...         return Layer()  # its method `motor` replaces the motor's output
    >>> fault = HotMotor(value=0.5, after=2.0)
    >>> fault.is_active(1.0), fault.is_active(3.0), HotMotor.fits(Motor)
    (False, True, True)
    """

    target_classes: ClassVar[tuple[type, ...]] = ()
    example: ClassVar[str] = ""

    after: Moment = 0.0
    lasts: Duration | None = None

    @classmethod
    def fits(cls, target: TargetClass) -> bool:
        """Return whether the fault can affect targets of a class."""
        return issubclass(target, cls.target_classes)

    @abstractmethod
    def layer(self, context: FaultContext) -> Layer:
        """Return the layer that makes devices fail. A run applies it to the devices of the target and to the clock."""

    def is_active(self, time: float) -> bool:
        """Return whether the fault is active at ``time``, in seconds on the robot's clock."""
        return -ROUNDING_S <= time - self.after < (self.lasts or inf) - ROUNDING_S


class PollingLayer(Layer):
    """A layer that reads its sensors in every tick. It reads a sensor at the end of a tick if the app did not.

    >>> from robotcore.hal.clock import SteppedClock
    >>> layer, reads = PollingLayer(), []
    >>> read = layer.poll(lambda: reads.append("read"))
    >>> clock = layer.clock(SteppedClock(20, lambda steps: None))
    >>> clock.sleep_until(0.05), reads  # nothing has read the sensor in the tick
    (True, ['read'])
    """

    def __init__(self) -> None:
        self._readers: list[Reader[Any]] = []
        self._read: set[Reader[Any]] = set()
        """The readers that were called in this tick."""

    def poll(self, read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a function that calls ``read``. If nothing calls it in a tick, the layer calls it at the end."""

        def polled() -> SampleT:
            self._read.add(read)
            return read()

        self._readers.append(read)
        return polled

    def clock(self, clock: Clock) -> Clock:
        return _PollingClock(clock, self._end_tick)

    def _end_tick(self) -> None:
        for read in self._readers:
            if read not in self._read:
                with suppress(DeviceError):
                    read()
        self._read.clear()


class _PollingClock(ClockWrapper):
    def __init__(self, source: Clock, end_tick: Callable[[], None]) -> None:
        super().__init__(source)
        self._end_tick = end_tick

    def sleep_until(self, deadline: float) -> bool:
        self._end_tick()
        return super().sleep_until(deadline)


class SensorFault(Fault):
    """The base class of faults that change the samples of sensors."""

    is_polling: ClassVar[bool] = False
    """Whether the fault needs the sample of every tick, also if the app does not read the sensor."""

    @abstractmethod
    def change(self, context: FaultContext, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        """Return the function that reads a sensor with this fault. It calls ``read``."""

    def layer(self, context: FaultContext) -> Layer:
        return _SensorLayer(self, context)


class _SensorLayer(PollingLayer):
    def __init__(self, fault: SensorFault, context: FaultContext) -> None:
        super().__init__()
        self._fault, self._context = fault, context

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        changed = self._fault.change(self._context, sensor, read)
        return self.poll(changed) if self._fault.is_polling else changed
