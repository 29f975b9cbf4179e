from __future__ import annotations

from collections.abc import Iterator

import pytest
from gpiozero import Motor, OutputDevice, PhaseEnableMotor

from drivers.raspberrypi.virtual.pins import VirtualPins
from drivers.raspberrypi.virtual.wheels import wire_phase_and_enable, wire_two_inputs
from robotcore.hal.clock import SteppedClock
from tests.drivers.raspberrypi.virtual.fakes import FakeMotor


@pytest.fixture
def pins() -> Iterator[VirtualPins]:
    with VirtualPins(SteppedClock(20.0, lambda steps: None)) as factory:
        yield factory


def ten_times(duty: float) -> float:
    return 10 * duty


@pytest.mark.parametrize("duty", [0.5, -0.25, 0.0])
def test_two_inputs_turn_the_wheel_at_once(duty: float, pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_two_inputs(wheel, ten_times, pins.pin(17), pins.pin(27))
    with Motor(17, 27, pin_factory=pins) as motor:
        motor.value = duty
        assert wheel.velocity == pytest.approx(10 * duty)
    assert wheel.velocity == 0


@pytest.mark.parametrize("duty", [0.5, -0.25, 0.0])
def test_phase_and_enable_turn_the_wheel_at_once(duty: float, pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_phase_and_enable(wheel, ten_times, pins.pin(17), pins.pin(27))
    with PhaseEnableMotor(17, 27, pin_factory=pins) as motor:
        motor.value = duty
        assert wheel.velocity == pytest.approx(10 * duty)
    assert wheel.velocity == 0


def test_wheel_stands_while_its_bridge_is_not_enabled(pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_two_inputs(wheel, ten_times, pins.pin(17), pins.pin(27), pins.pin(22))
    with Motor(17, 27, pin_factory=pins) as motor:
        motor.value = 0.5
        assert wheel.velocity == 0
        with OutputDevice(22, initial_value=True, pin_factory=pins):
            assert wheel.velocity == 5
        assert wheel.velocity == 0


def test_both_inputs_alike_brake(pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_two_inputs(wheel, ten_times, pins.pin(17), pins.pin(27))
    with OutputDevice(17, initial_value=True, pin_factory=pins), OutputDevice(27, pin_factory=pins) as backward:
        assert wheel.velocity == 10
        backward.on()
        assert wheel.velocity == 0
