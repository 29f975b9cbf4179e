"""What a layer is: something that fits over any device of a robot."""

from __future__ import annotations

from collections.abc import Callable

from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
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
from robotcore.runtime.layers.readers import Reader
from robotcore.safety import Latch, Stage


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

    def stage(self, stage: Stage) -> Stage:
        """Return what takes the commands of the drive."""
        return stage

    def lone_motor(self, motor: Motor) -> Motor:
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
