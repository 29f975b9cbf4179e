"""Two layers that check a run: the age of samples, and the duration of driver calls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from types import FrameType
from typing import Any

from robotcore.errors import BackendError, DeviceError, RobotcoreError, StaleSampleError
from robotcore.hal.clock import Clock, ClockWrapper, TickClock
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader, Send
from robotcore.safety.latch import Latch
from robotcore.safety.watchdog import ActivityMonitor, TimeLimit


class MaxAgeLayer(Layer):
    """Ends the run with StaleSampleError if a sample is older than ``limit`` seconds, or has the time of another clock.

    The sample of a monitored sensor, such as a battery, may be older.

    longest_step: the longest duration of a step, in seconds. A sample may be newer than the begin of its tick.
    """

    def __init__(self, clock: TickClock, limit: float, longest_step: float, latch: Latch) -> None:
        self._clock, self._limit, self._latch = clock, limit, latch
        self._newest = -longest_step - limit

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if sensor.is_monitored:
            return read
        clock, limit, newest = self._clock, self._limit, self._newest

        def read_checked() -> SampleT:
            sample = read()
            age = clock.now() - sample.time
            if not newest <= age <= limit:  # NaN too
                self._latch.trip(StaleSampleError(sensor.name, age, limit))
            return sample

        return read_checked


GRACE_S = 0.3
"""The time in seconds that the thread has to continue after the watchdog has interrupted it."""

SHORT_S = 0.06
"""Only a sleep longer than this, in seconds, raises the time limit of its call."""

_ADVICE = "Check that it runs and is connected. If it is only slow, raise safety.answer_s in the robot's description"


@dataclass(frozen=True)
class CallMonitorLayer(Layer):
    """Records each call of a driver and each sleep for the watchdog."""

    activity: ActivityMonitor
    """The record of the loop thread's activity."""
    answer_s: float
    """The time limit of one driver call, in seconds."""
    robot: str
    """The robot's name, for messages."""

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return partial(self.activity.call_driver, self._limit_call(sensor.name), read)

    def motor(self, motor: MotorOutput) -> MotorOutput:
        limit, activity = self._limit_call(motor.name), self.activity
        return MotorOutput(
            motor.name,
            partial(activity.call_driver, limit, motor.set_velocity),
            partial(activity.call_driver, limit, motor.stop),
        )

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        return partial(self.activity.call_driver, self._limit_call(actuator.name), send)

    def clock(self, clock: Clock) -> Clock:
        return _MonitoredClock(clock, self.activity, TimeLimit(self.answer_s, self._build_clock_error, GRACE_S))

    def _limit_call(self, device: str) -> TimeLimit:
        def build_error(seconds: float, _frame: FrameType | None) -> RobotcoreError:
            return DeviceError(device, f"has not answered for {seconds:.1f} s. {_ADVICE}", kind="device-hangs")

        return TimeLimit(self.answer_s, build_error, GRACE_S)

    def _build_clock_error(self, seconds: float, _frame: FrameType | None) -> RobotcoreError:
        return BackendError(
            f"the backend of {self.robot!r} has not returned from a sleep for {seconds:.1f} s. {_ADVICE}",
            kind="backend-hangs",
        )


class _MonitoredClock(ClockWrapper):
    """A backend's clock whose calls the watchdog checks.

    The time limit of a sleep is the limit of a driver call plus the duration of the sleep. An exception of the driver
    during a sleep is raised as BackendError.
    """

    def __init__(self, source: Clock, activity: ActivityMonitor, limit: TimeLimit) -> None:
        super().__init__(source)
        self._activity, self._limit = activity, limit
        self._last = 0.0

    def now(self) -> float:
        self._last = now = self._activity.call_driver(self._limit, self._source.now)
        return now

    def sleep_until(self, deadline: float) -> bool:
        ahead, limit = deadline - self._last, self._limit
        if ahead > SHORT_S:
            limit = limit._replace(limit_s=limit.limit_s + ahead)
        try:
            return self._activity.call_driver(limit, self._source.sleep_until, deadline)
        except (RobotcoreError, MemoryError):
            raise
        except Exception as broken:
            cause = f"{type(broken).__name__}: {broken}".removesuffix(": ")
            raise BackendError(
                f"the backend's clock failed: {cause}. Check that the simulator is still running",
                kind="connection-broken",
            ) from broken
