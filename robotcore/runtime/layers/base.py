"""The base classes of layers: what a layer can replace on its way from the driver to the app."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import Generic

from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock, TickClock
from robotcore.hal.devices import (
    Angle,
    Battery,
    Camera,
    Display,
    Encoder,
    Frame,
    Motor,
    Range,
    RangeSensor,
    SampleT,
    Sensor,
    Voltage,
)
from robotcore.safety import CommandFilter, Latch

Reader = Callable[[], SampleT]


class TickCache(Generic[SampleT]):
    """Within one tick, one sample, however often it is read; ``latest`` is the one read last."""

    def __init__(self, clock: TickClock, read: Reader[SampleT]) -> None:
        self._clock = clock
        self._read = read
        self._tick = -1
        self._sample: SampleT | None = None

    @property
    def latest(self) -> SampleT | None:
        return self._sample

    def __call__(self) -> SampleT:
        if self._sample is None or self._tick != self._clock.tick:
            self._sample = self._read()
            self._tick = self._clock.tick
        return self._sample


class Layer:
    """Fits over the devices of a robot; what it does not change, it hands on as it is.

    A sensor's layer is a function: ``read`` reads the sensor as the layers below give it. Override `sensor` for what is
    the same for every sensor, and the kind's own method for what is not.
    """

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return what reads any sensor through this layer."""
        return read

    def camera(self, camera: Camera, read: Reader[Frame]) -> Reader[Frame]:
        """Return what reads a camera through this layer."""
        return self.sensor(camera, read)

    def range_sensor(self, sensor: RangeSensor, read: Reader[Range]) -> Reader[Range]:
        """Return what reads a range sensor through this layer."""
        return self.sensor(sensor, read)

    def encoder(self, encoder: Encoder, read: Reader[Angle]) -> Reader[Angle]:
        """Return what reads an encoder through this layer."""
        return self.sensor(encoder, read)

    def battery(self, battery: Battery, read: Reader[Voltage]) -> Reader[Voltage]:
        """Return what reads a battery through this layer."""
        return self.sensor(battery, read)

    def motor(self, motor: Motor) -> Motor:
        """Return the motor as whoever is above commands it."""
        return motor

    def display(self, display: Display) -> Display:
        """Return the display as whoever is above shows pictures on it."""
        return display

    def command_filter(self, inner: CommandFilter) -> CommandFilter:
        """Return what takes the commands of the drive."""
        return inner

    def standalone_motor(self, motor: Motor) -> Motor:
        """Return a motor that belongs to no drive, guarded, as the app commands it."""
        return motor

    def angles(self, read: Callable[[], Wheels]) -> Callable[[], Wheels]:
        """Return what reads the angles of the wheels, in radians, by which the drive knows its pose."""
        return read

    def clock(self, clock: Clock) -> Clock:
        """Return the clock as the loop is to sleep by it."""
        return clock

    def latch(self, latch: Latch) -> None:
        """Learn what ends the run for good; told once, before anything is read."""


class MotorWrapper(Motor):
    """A motor seen through a layer; what it is told goes as a subclass has it, a stop goes straight to the motor."""

    def __init__(self, inner: Motor) -> None:
        super().__init__(inner.name, inner.max_velocity)
        self._inner = inner

    def stop(self) -> None:
        if not self._is_closed:
            self._inner.stop()

    def _release(self) -> None:
        self._inner.close()


def limit_reading(sensor: RangeSensor, reading: Range, distance: float) -> Range:
    """Return a reading at another distance: never nearer than the sensor can tell, and ``inf`` past its range."""
    if distance > sensor.max_range:
        return replace(reading, distance=inf, point=None)
    return replace(reading, distance=max(distance, sensor.min_range))
