"""Layers one over the other, over whatever device there is."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import reduce
from typing import Any

from robotcore.hal.clock import Clock, TickClock
from robotcore.hal.devices import Battery, Camera, Device, Display, Encoder, Motor, RangeSensor, SampleT, Sensor
from robotcore.runtime.layers.devices import (
    LayeredBattery,
    LayeredCamera,
    LayeredDisplay,
    LayeredEncoder,
    LayeredRangeSensor,
)
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.readers import OnceATick, Reader


@dataclass(frozen=True)
class Stack:
    """The layers over every device, the lowest first; above them a sensor is read once a tick."""

    clock: TickClock
    layers: tuple[Layer, ...]

    def over(self, device: Device) -> Device:
        """Return a device under the layers."""
        match device:
            case Sensor():
                return self._over_sensor(device)
            case Motor():
                return reduce(lambda motor, layer: layer.motor(motor), self.layers, device)
            case Display():
                return LayeredDisplay(reduce(lambda display, layer: layer.display(display), self.layers, device))
        return device

    def _over_sensor(self, sensor: Sensor[Any]) -> Device:
        match sensor:
            case Camera() as camera:
                return LayeredCamera(camera, self._read(camera.read, lambda layer, read: layer.camera(camera, read)))
            case RangeSensor() as ear:
                return LayeredRangeSensor(ear, self._read(ear.read, lambda layer, read: layer.range_sensor(ear, read)))
            case Encoder() as wheel:
                return LayeredEncoder(wheel, self._read(wheel.read, lambda layer, read: layer.encoder(wheel, read)))
            case Battery() as cell:
                return LayeredBattery(cell, self._read(cell.read, lambda layer, read: layer.battery(cell, read)))
        return sensor

    def over_lone(self, motor: Motor) -> Motor:
        """Return a motor that belongs to no drive under what the layers put over its guard."""
        return reduce(lambda motor, layer: layer.lone_motor(motor), self.layers, motor)

    def _read(
        self, read: Reader[SampleT], through: Callable[[Layer, Reader[SampleT]], Reader[SampleT]]
    ) -> OnceATick[SampleT]:
        for layer in self.layers:
            read = through(layer, read)
        return OnceATick(self.clock, read)


def slept_by(clock: Clock, layers: Iterable[Layer]) -> Clock:
    """Return the clock as a loop under the layers is to sleep by it."""
    return reduce(lambda slept, layer: layer.clock(slept), layers, clock)
