"""The devices of an app. Each wraps a device of a driver and calls it through the layers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, cast

from robotcore.errors import DeviceClosedError, RobotcoreError
from robotcore.geometry import to_float
from robotcore.hal.clock import TickClock
from robotcore.hal.device import Actuator, Device, SampleT, Sensor, build_driver_error
from robotcore.hal.kind import load_kind
from robotcore.kinds.motor import Motor
from robotcore.runtime.layers.base import MotorOutput, Reader, Send
from robotcore.safety.latch import Latch

ROUNDING = 0.01
"""The largest difference between a command and the rounded one that was sent."""


class AppSensor(Sensor[SampleT]):
    """A sensor that reads a driver's sensor through the layers. All reads within a tick return the same sample.

    The attributes that the class of the kind does not define are those of the driver's sensor.
    """

    def __init__(self, inner: Sensor[SampleT], clock: TickClock, read: Reader[SampleT]) -> None:
        Device.__init__(self, inner.name)
        self._inner, self._clock, self._read_layers = inner, clock, read
        self._reading = -1
        self.latest: SampleT | None = None
        self.read_count = 0
        """The number of calls of `read`."""

    def read(self) -> SampleT:
        if self._is_closed:
            raise DeviceClosedError(self.name)
        self._clock.renew()
        self.read_count += 1
        if self.latest is None or self._reading != self._clock.reading:
            try:  # as in `_attempt`, without its call
                self.latest = self._read_layers()
            except RobotcoreError:
                raise
            except Exception as error:
                raise build_driver_error(self.name, error) from error
            self._reading = self._clock.reading
        return self.latest

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the driver's sensor, such as a camera's intrinsics."""
        return _get_inner(self, self._inner, name)

    def __dir__(self) -> list[str]:
        return _list_names(super().__dir__(), self._inner)

    def _format_state(self) -> str:
        return "" if self.latest is None else f"{self.format_sample(self.latest)} at {self.latest.time:.2f} s"

    def _newest(self) -> SampleT:
        return self.read()

    def _release(self) -> None:
        self._inner.close()


def wrap_sensor(sensor: Sensor[SampleT], clock: TickClock, read: Reader[SampleT]) -> Sensor[SampleT]:
    """Return a sensor of the same kind that calls ``read``. ``clock`` counts the ticks."""
    return _app_class(sensor.kind)(sensor, clock, read)


@cache
def _app_class(kind: str) -> type[AppSensor[Any]]:
    """Return a subclass of AppSensor and of the class of a kind, such as Camera."""
    device: Any = load_kind(kind).device
    return cast("type[AppSensor[Any]]", type(device.__name__, (AppSensor, device), {}))


class AppMotor(Motor):
    """A motor that sends its commands to ``output``. `close` closes the driver's motor."""

    def __init__(self, inner: Motor, output: MotorOutput) -> None:
        super().__init__(inner.name, inner.max_velocity)
        self._inner, self._output = inner, output

    def __repr__(self) -> str:
        return super().__repr__().replace(AppMotor.__name__, Motor.__name__, 1)  # as sensors show their kind

    def set_velocity(self, rad_s: float) -> float:
        if self._is_closed:
            raise DeviceClosedError(self.name)
        return self._attempt(self._output.set_velocity, to_float(rad_s))

    def stop(self) -> None:
        if not self._is_closed:
            self._output.stop()

    def _apply(self, rad_s: float) -> None:
        self.set_velocity(rad_s)

    def _release(self) -> None:
        self._inner.close()


class AppActuator(Actuator[Any]):
    """An actuator that sends its commands through the layers.

    The attributes that the class of the kind does not define are those of the driver's actuator.

    send: sends a command through the layers.
    latch: the latch of the run. After it has tripped, the actuator takes no command but a stop. None: it takes all.

    ``latest`` is the newest command.
    """

    def __init__(self, inner: Actuator[Any], send: Send, latch: Latch | None) -> None:
        Device.__init__(self, inner.name)
        self._inner, self._send_layers, self._latch = inner, send, latch
        self.latest = self._last_sent = None
        self._send_count = self._limited_count = 0
        self._first_limited = ""

    def send(self, command: Any) -> Any:
        if self._latch:
            self._latch.check()
        sent = self._send(command)
        self._send_count += 1
        if _is_limited(command, sent):
            self._limited_count += 1
            self._first_limited = self._first_limited or f"from {command} to {sent}"
        return sent

    def describe_limits(self) -> str:
        """Return a note if most commands were outside the actuator's limits, or else ``""``."""
        if self._limited_count <= self._send_count / 2:
            return ""
        counted = f"{self._limited_count} of {self._send_count} commands were limited, the first {self._first_limited}"
        return f"{self.name}: {counted}. Check their unit"

    def stop(self) -> None:
        """Send the safe command through the layers, so that it is recorded and verified in a replay."""
        if self._is_closed:
            return
        if self.safe_command is None:
            self._inner.stop()
        else:
            self._send(self.safe_command)

    def close(self) -> None:
        Device.close(self)  # the driver's actuator stops itself

    def _send(self, command: Any) -> Any:
        if self._is_closed:
            raise DeviceClosedError(self.name)
        self.latest = command
        self._last_sent = self._attempt(self._send_layers, command)
        return self._last_sent

    def _format_state(self) -> str:
        return "" if self._last_sent is None else self.format_command(self._last_sent)

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the driver's actuator, such as a servo's limits."""
        return _get_inner(self, self._inner, name)

    def __dir__(self) -> list[str]:
        return _list_names(super().__dir__(), self._inner)

    def _apply(self, command: Any) -> None:
        self.send(command)

    def _release(self) -> None:
        self._inner.close()


def _is_limited(command: Any, sent: Any) -> bool:
    if isinstance(command, tuple) and isinstance(sent, tuple):
        return any(map(_is_limited, command, sent))
    if not (isinstance(command, (int, float)) and isinstance(sent, (int, float))):
        return False  # such as a picture
    return not math.isclose(command, sent, rel_tol=ROUNDING, abs_tol=ROUNDING)


def wrap_actuator(actuator: Actuator[Any], send: Send, latch: Latch | None) -> Actuator[Any]:
    """Return an actuator of the same kind that calls ``send``, and refuses commands after ``latch`` has tripped."""
    return _app_actuator_class(actuator.kind)(actuator, send, latch)


@cache
def _app_actuator_class(kind: str) -> Callable[..., AppActuator]:
    device: Any = load_kind(kind).device
    return type(device.__name__, (AppActuator, device), {})


def _list_names(names: Iterable[str], inner: Device) -> list[str]:
    return sorted({*names, *(name for name in vars(inner) if not name.startswith("_"))})


def _get_inner(device: Device, inner: Device, name: str) -> Any:
    if name.startswith("_") or not hasattr(inner, name):
        text = f"the {type(device).__name__} {device.name!r} has no attribute {name!r}"
        raise AttributeError(text, name=name, obj=device)
    return getattr(inner, name)
