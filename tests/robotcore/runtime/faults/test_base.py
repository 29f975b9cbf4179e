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


class Noting(Layer):
    """Notes which devices it was put over."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        self.names.append(sensor.name)
        return read

    def motor(self, motor: MotorOutput) -> MotorOutput:
        self.names.append(motor.name)
        return motor


def put_over(layer: Layer, device: Failing) -> None:
    if isinstance(device, Motor):
        layer.motor(MotorOutput.of(device))
    else:
        sensor: Sensor[Any] = device
        layer.sensor(sensor, sensor.read)


@pytest.mark.parametrize("made", [NullCamera, NullRange, NullEncoder, lambda _, name: NullMotor(name)])
def test_a_layer_is_put_over_the_devices_of_its_target_only(made: Callable[[Clock, str], Failing]) -> None:
    clock, noting = SteppedClock(20, lambda _: None), Noting()
    layer = DeviceFilter(noting, {"mine"})
    for name in ("mine", "other"):
        put_over(layer, made(clock, name))
    assert noting.names == ["mine"]


@pytest.mark.parametrize("after, lasts", [(5.0, 0.3), (0.3, 0.1), (0.1, 0.2)])
def test_a_fault_is_there_from_its_first_tick_and_not_at_its_last(after: float, lasts: float) -> None:
    fault = Stuck(value=1.0, after=after, lasts=lasts)
    ticks = [tick for tick in range(120) if fault.is_on(tick / 20)]
    assert ticks == list(range(round(20 * after), round(20 * (after + lasts))))
