from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.devices import Camera, Encoder, Motor, RangeSensor, SampleT, Sensor
from robotcore.runtime.faults.planning import DeviceFilter
from robotcore.runtime.faults.sensor_values import Stuck
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader
from tests.robotcore.fakes import NullCamera, NullEncoder, NullMotor, NullRange

Failing = Camera | RangeSensor | Encoder | Motor


class RecordingLayer(Layer):
    """Records the names of the devices that it wraps."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        self.names.append(sensor.name)
        return read

    def motor(self, motor: MotorOutput) -> MotorOutput:
        self.names.append(motor.name)
        return motor


def wrap(layer: Layer, device: Failing) -> None:
    if isinstance(device, Motor):
        layer.motor(MotorOutput.of(device))
    else:
        sensor: Sensor[Any] = device
        layer.sensor(sensor, sensor.read)


@pytest.mark.parametrize("made", [NullCamera, NullRange, NullEncoder, lambda _, name: NullMotor(name)])
def test_layer_wraps_only_the_devices_of_its_target(made: Callable[[Clock, str], Failing]) -> None:
    clock, recording = SteppedClock(20, lambda _: None), RecordingLayer()
    layer = DeviceFilter(recording, {"mine"})
    for name in ("mine", "other"):
        wrap(layer, made(clock, name))
    assert recording.names == ["mine"]


@pytest.mark.parametrize("after, lasts", [(5.0, 0.3), (0.3, 0.1), (0.1, 0.2)])
def test_fault_is_active_from_after_until_after_plus_lasts(after: float, lasts: float) -> None:
    fault = Stuck(value=1.0, after=after, lasts=lasts)
    ticks = [tick for tick in range(120) if fault.is_on(tick / 20)]
    assert ticks == list(range(round(20 * after), round(20 * (after + lasts))))
