"""A layer that applies a fault to the devices of its target. The fault may be part of another package."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from numbers import Real
from typing import Any, ParamSpec, TypeVar

from robotcore.errors import BackendError, DeviceError, RobotcoreError, UsageError, describe_exception
from robotcore.hal.clock import Clock, ClockWrapper
from robotcore.hal.device import Actuator, SampleT, Sensor
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader, Send

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True)
class FaultCode:
    """Calls the code of one fault. An exception of this code becomes an error that contains the fault.

    The error is a DeviceError if the call is for a device, otherwise a BackendError.
    """

    fault: str
    """The specification of the fault."""

    def call(self, device: str, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a function of this code. ``device`` is the device of the call, or an empty text."""
        try:
            return function(*args, **kwargs)
        except (Exception, SystemExit) as error:
            if isinstance(error, (RobotcoreError, MemoryError)) and not isinstance(error, UsageError):
                raise  # it is of a device or the backend below the fault
            raise self._build_error(describe_exception(error, __file__), device) from error

    def get(self, device: str, kind: Any, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a function as `call` does. A result of None, or of another type than ``kind``, is an error too."""
        result = self.call(device, function, *args, **kwargs)
        if result is None or not isinstance(result, kind):
            name = getattr(function, "__qualname__", function)
            raise self._build_error(f"{name} returned {result!r:.50}", device)
        return result

    def _build_error(self, problem: str, device: str) -> RobotcoreError:
        text = f'the fault "{self.fault}" does not work: {problem}. Correct its code, or leave the fault out'
        if device:
            return DeviceError(device, text, kind="fault-code", fault=self.fault)
        return BackendError(text, kind="fault-code", fault=self.fault)


class CheckedLayer(Layer):
    """Applies the layer of a fault to the clock and to the devices with these names, and to no other device.

    If the code of a motor's stop raises an exception, the stop is still sent to the driver.
    """

    def __init__(self, layer: Layer, code: FaultCode, devices: Collection[str]) -> None:
        self._layer, self._code, self._devices = layer, code, devices

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if sensor.name not in self._devices:
            return read
        changed = self._code.get(sensor.name, Callable, self._layer.sensor, sensor, read)
        return lambda: self._code.get(sensor.name, object, changed)

    def motor(self, motor: MotorOutput) -> MotorOutput:
        if motor.name not in self._devices:
            return motor
        changed = self._code.get(motor.name, MotorOutput, self._layer.motor, motor)

        def stop() -> None:
            try:
                self._code.call(motor.name, changed.stop)
            except BaseException:
                motor.stop()
                raise

        def set_velocity(rad_s: float) -> float:
            return self._code.get(motor.name, Real, changed.set_velocity, rad_s)

        return MotorOutput(motor.name, set_velocity, stop)

    def actuator(self, actuator: Actuator[Any], send: Send) -> Send:
        if actuator.name not in self._devices:
            return send
        changed = self._code.get(actuator.name, Callable, self._layer.actuator, actuator, send)
        return lambda command: self._code.call(actuator.name, changed, command)

    def clock(self, clock: Clock) -> Clock:
        changed = self._code.get("", Clock, self._layer.clock, clock)
        return clock if changed is clock else _CheckedClock(changed, self._code)


class _CheckedClock(ClockWrapper):
    def __init__(self, source: Clock, code: FaultCode) -> None:
        code.call("", super().__init__, source)
        self._code = code

    def now(self) -> float:
        return self._code.get("", Real, self._source.now)

    def sleep_until(self, deadline: float) -> bool:
        return self._code.call("", self._source.sleep_until, deadline)
