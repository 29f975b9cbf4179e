"""A layer that reports the errors in the code of a fault. The fault may be part of another package."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from traceback import extract_tb
from typing import ParamSpec, TypeVar

from robotcore.errors import BackendError, DeviceError, RobotcoreError, UsageError
from robotcore.hal.clock import Callback, Clock, ClockWrapper, PeriodicTask
from robotcore.hal.devices import Display, SampleT, Sensor
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader, Show

P = ParamSpec("P")
T = TypeVar("T")


class FaultCode:
    """Calls the code of one fault. It converts the exceptions of this code to errors that contain the fault.

    fault: the specification of the fault.
    """

    def __init__(self, fault: str) -> None:
        self._fault = fault

    def build_error(self, problem: str, device: str = "") -> RobotcoreError:
        """Return the error for a problem in this code.

        problem: a clause such as ``Fog.layer returned None``.
        device: the device of the problem. With a device the error is a DeviceError, otherwise a BackendError.
        """
        text = f'the fault "{self._fault}" does not work: {problem}. Correct its code, or leave the fault out'
        if device:
            return DeviceError(device, text, kind="fault-code", fault=self._fault)
        return BackendError(text, kind="fault-code", fault=self._fault)

    def translate(self, error: BaseException, device: str = "") -> RobotcoreError:
        """Return the error for an exception that this code raised. It contains the line that raised the exception."""
        text = f"{type(error).__name__}: {error}".removesuffix(": ")
        last = extract_tb(error.__traceback__)[-1]
        line = "" if last.filename == __file__ else f", at {Path(last.filename).name}:{last.lineno}"
        return self.build_error(text + line, device)

    def call(self, device: str, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a function of this code, and translate its exceptions. ``device`` is an argument of `build_error`."""
        try:
            return function(*args, **kwargs)
        except (Exception, SystemExit) as error:
            if can_end_run(error):
                raise
            raise self.translate(error, device) from error


def can_end_run(error: BaseException) -> bool:
    """Return whether an error can end a run as it is.

    A UsageError cannot, because its message would claim that the user's request is wrong.
    """
    return isinstance(error, RobotcoreError) and not isinstance(error, UsageError)


class CheckedLayer(Layer):
    """Applies another layer, and translates the exceptions of its code.

    If the code of a motor's stop raises an exception, the stop is still sent to the driver.
    """

    def __init__(self, layer: Layer, code: FaultCode) -> None:
        self._layer, self._code = layer, code

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        inner = partial(_read_inner, sensor.name, read)
        changed = self._code.call(sensor.name, self._layer.sensor, sensor, inner)
        if not callable(changed):
            raise self._build_type_error(changed, "sensor", "function", sensor.name)
        return read if changed is inner else partial(self._read, sensor.name, changed)

    def motor(self, motor: MotorOutput) -> MotorOutput:
        changed = self._code.call(motor.name, self._layer.motor, motor)
        if not isinstance(changed, MotorOutput):
            raise self._build_type_error(changed, "motor", "MotorOutput", motor.name)
        if changed is motor:
            return motor
        stop = partial(self._stop, changed, motor)
        return MotorOutput(motor.name, partial(self._set_velocity, changed), stop)

    def display(self, display: Display, show: Show) -> Show:
        changed = self._code.call(display.name, self._layer.display, display, show)
        if not callable(changed):
            raise self._build_type_error(changed, "display", "function", display.name)
        return show if changed is show else lambda image: self._code.call(display.name, changed, image)

    def clock(self, clock: Clock) -> Clock:
        inner = _InnerClock(clock)
        changed = self._code.call("", self._layer.clock, inner)
        if not isinstance(changed, Clock):
            raise self._build_type_error(changed, "clock", "Clock")
        return clock if changed is inner else _CheckedClock(changed, inner, self._code)

    def _build_type_error(self, result: object, method: str, expected: str, device: str = "") -> RobotcoreError:
        name = f"{type(self._layer).__name__}.{method}"
        return self._code.build_error(f"{name} returned {result!r:.100} in place of a {expected}", device)

    def _read(self, device: str, read: Reader[SampleT]) -> SampleT:
        sample = self._code.call(device, read)
        if sample is None:
            raise self._code.build_error("a read returned None in place of a sample", device)
        return sample

    def _set_velocity(self, motor: MotorOutput, rad_s: float) -> float:
        sent = self._code.call(motor.name, motor.set_velocity, rad_s)
        if sent is None:
            raise self._code.build_error("set_velocity returned None in place of the velocity in rad/s", motor.name)
        return sent

    def _stop(self, changed: MotorOutput, inner: MotorOutput) -> None:
        try:
            changed.stop()
        except BaseException as error:
            inner.stop()
            if not isinstance(error, (Exception, SystemExit)) or can_end_run(error):
                raise
            raise self._code.translate(error, inner.name) from error


def _read_inner(device: str, read: Reader[SampleT]) -> SampleT:
    # An exception of the driver is translated here, so that it does not look like an exception of the fault.
    try:
        return read()
    except RobotcoreError:
        raise
    except Exception as error:
        text = f"{type(error).__name__}: {error}".removesuffix(": ")
        raise DeviceError(device, text, kind="driver-error") from error


class _InnerClock(ClockWrapper):
    """The clock below the fault. It stores its last exception, which the fault has not caused."""

    failure: BaseException | None = None

    def now(self) -> float:
        try:
            return self._source.now()
        except BaseException as error:
            self.failure = error
            raise

    def sleep_until(self, deadline: float) -> bool:
        try:
            return self._source.sleep_until(deadline)
        except BaseException as error:
            self.failure = error
            raise


class _CheckedClock(ClockWrapper):
    def __init__(self, source: Clock, inner: _InnerClock, code: FaultCode) -> None:
        self._inner, self._code = inner, code
        code.call("", super().__init__, source)

    def now(self) -> float:
        now = self._call(self._source.now)
        if now is None:
            raise self._code.build_error("now() of its clock returned None in place of the time in seconds")
        return now

    def sleep_until(self, deadline: float) -> bool:
        return self._call(self._source.sleep_until, deadline)

    def call_at(self, deadline: float, callback: Callback) -> None:
        self._call(self._source.call_at, deadline, callback)

    def prepare_calls(self) -> None:
        self._call(self._source.prepare_calls)

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        return self._call(self._source.every, period, work, name)

    def time_of(self, monotonic_s: float) -> float:
        return self._call(self._source.time_of, monotonic_s)

    def _call(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except (Exception, SystemExit) as error:
            if error is self._inner.failure or can_end_run(error):
                raise
            raise self._code.translate(error) from error
