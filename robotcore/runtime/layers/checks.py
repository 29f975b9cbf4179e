"""Two layers of checks: the age of samples, and the duration of driver calls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from types import FrameType
from typing import Generic

from robotcore.errors import BackendError, DeviceError, RobotcoreError, StaleSampleError
from robotcore.hal.clock import Clock, ClockWrapper, TickClock
from robotcore.hal.devices import Battery, SampleT, Sensor
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader
from robotcore.safety import ActivityMonitor, Latch, TimeLimit


class MaxAgeLayer(Layer):
    """No sensor's sample is older than ``limit`` seconds: StaleSampleError instead, which ends the run.

    A battery's may be: nobody drives by it.
    """

    def __init__(self, clock: TickClock, limit: float, latch: Latch) -> None:
        self._clock, self._limit, self._latch = clock, limit, latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if isinstance(sensor, Battery):
            return read
        return MaxAgeReader(sensor.name, self._clock, self._limit, self._latch, read)


class MaxAgeReader(Generic[SampleT]):
    """Reads one sensor, and trips the latch where its newest sample is too old."""

    def __init__(self, device: str, clock: TickClock, limit: float, latch: Latch, read: Reader[SampleT]) -> None:
        self._device, self._clock, self._limit, self._latch, self._read = device, clock, limit, latch, read

    def __call__(self) -> SampleT:
        sample = self._read()
        age = self._clock.now() - sample.time
        if age > self._limit:
            self._latch.trip(StaleSampleError(self._device, age, self._limit))
        return sample


GRACE_S = 0.3
"""So that a simulator that hangs is named within two seconds also where nothing brings the program back."""

SHORT_S = 0.06
"""A sleep of a tick at 20 Hz, which matters little beside what an answer may take."""

_ADVICE = "Is it still running and connected? Where it is only slow, raise safety.answer_s in the robot's description"


@dataclass(frozen=True)
class CallMonitorLayer(Layer):
    """Notes each call of a driver, and each sleep.

    ``answer_s`` is how long one may take, ``robot`` the robot's name.
    """

    where: ActivityMonitor
    answer_s: float
    robot: str

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return partial(self.where.call_driver, self._stay_in(sensor.name), read)

    def motor(self, motor: MotorOutput) -> MotorOutput:
        limit, where = self._stay_in(motor.name), self.where
        return MotorOutput(
            motor.name,
            partial(where.call_driver_with, limit, motor.set_velocity),
            partial(where.call_driver, limit, motor.stop),
        )

    def clock(self, clock: Clock) -> Clock:
        return _MonitoredClock(clock, self.where, TimeLimit(self.answer_s, self._unpassed, GRACE_S))

    def _stay_in(self, device: str) -> TimeLimit:
        def unanswered(seconds: float, _frame: FrameType | None) -> RobotcoreError:
            return DeviceError(device, f"has not answered for {seconds:.1f} s. {_ADVICE}")

        return TimeLimit(self.answer_s, unanswered, GRACE_S)

    def _unpassed(self, seconds: float, _frame: FrameType | None) -> RobotcoreError:
        return BackendError(
            f"the backend of {self.robot!r} has not answered for {seconds:.1f} s, while time was to pass. {_ADVICE}"
        )


class _MonitoredClock(ClockWrapper):
    """A backend's clock. A sleep may take as long as it was to take, and then as long as any call.

    A connection that breaks while time is to pass, and that the driver has not translated, is a BackendError.
    """

    def __init__(self, source: Clock, where: ActivityMonitor, stay: TimeLimit) -> None:
        super().__init__(source)
        self._where, self._stay = where, stay
        self._last = 0.0

    def now(self) -> float:
        self._last = now = self._where.call_driver(self._stay, self._source.now)
        return now

    def sleep_until(self, deadline: float) -> bool:
        ahead, stay = deadline - self._last, self._stay
        if ahead > SHORT_S:
            stay = stay._replace(limit_s=stay.limit_s + ahead)
        try:
            return self._where.call_driver_with(stay, self._source.sleep_until, deadline)
        except RobotcoreError:
            raise
        except (OSError, EOFError) as broken:
            fault = f"{type(broken).__name__}: {broken}".removesuffix(": ")
            raise BackendError(f"the backend lets no time pass: {fault}. Is the simulator still running?") from broken
