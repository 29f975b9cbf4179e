"""A layer over some devices only."""

from __future__ import annotations

from collections.abc import Collection

from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Battery, Camera, Display, Encoder, Frame, Motor, Range, RangeSensor, Voltage
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.readers import Reader


class Selected(Layer):
    """Puts ``layer`` over the devices of these names, and over the clock; all others stay as they are."""

    def __init__(self, layer: Layer, names: Collection[str]) -> None:
        self._layer, self._names = layer, names

    def camera(self, camera: Camera, read: Reader[Frame]) -> Reader[Frame]:
        return self._layer.camera(camera, read) if camera.name in self._names else read

    def range_sensor(self, sensor: RangeSensor, read: Reader[Range]) -> Reader[Range]:
        return self._layer.range_sensor(sensor, read) if sensor.name in self._names else read

    def encoder(self, encoder: Encoder, read: Reader[Angle]) -> Reader[Angle]:
        return self._layer.encoder(encoder, read) if encoder.name in self._names else read

    def battery(self, battery: Battery, read: Reader[Voltage]) -> Reader[Voltage]:
        return self._layer.battery(battery, read) if battery.name in self._names else read

    def motor(self, motor: Motor) -> Motor:
        return self._layer.motor(motor) if motor.name in self._names else motor

    def display(self, display: Display) -> Display:
        return self._layer.display(display) if display.name in self._names else display

    def clock(self, clock: Clock) -> Clock:
        return self._layer.clock(clock)
