"""Virtual pins, and the models on them: encoder discs, an ultrasonic module, motor boards."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from gpiozero import DigitalInputDevice, OutputDevice, PWMOutputDevice

from drivers.raspberrypi.virtual.models import (
    VirtualPins,
    read_two_inputs,
)
from robotcore.hal.clock import SteppedClock

EDGE = 0.01


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock(20.0, lambda steps: None)


@pytest.fixture
def pins(clock: SteppedClock) -> Iterator[VirtualPins]:
    with VirtualPins(clock) as factory:
        yield factory


def test_duty_is_cut_to_whole_percent_as_lgpio_does_it(pins: VirtualPins) -> None:
    with PWMOutputDevice(17, pin_factory=pins) as output:
        for duty, sent in ((0.379, 0.37), (0.29, 0.28), (1.0, 1.0), (0.0, 0.0)):
            output.value = duty
            assert pins.pin(17).state == sent


@contextmanager
def record_edges(number: int, pins: VirtualPins) -> Iterator[list[tuple[float, bool]]]:
    """Record the ticks and the level of each edge of an input."""
    edges: list[tuple[float, bool]] = []

    def record_edge(ticks: float, is_high: bool) -> None:
        edges.append((ticks, is_high))

    with DigitalInputDevice(number, pin_factory=pins) as device:
        device.pin.when_changed = record_edge
        yield edges
        device.pin.when_changed = None


def test_an_edge_from_outside_has_its_ticks_or_the_simulated_time(clock: SteppedClock, pins: VirtualPins) -> None:
    with record_edges(5, pins) as edges:
        clock.sleep_until(0.5)
        pins.pin(5).drive(1, 0.4321)
        pins.pin(5).drive(1)
        pins.pin(5).drive(0)
    assert edges == [(0.4321, True), (0.5, False)]


def test_a_driven_level_overrides_the_pull_of_an_input_and_an_output_ignores_it(pins: VirtualPins) -> None:
    with DigitalInputDevice(6, pull_up=True, pin_factory=pins) as device:
        assert device.pin.state
    for pull_up, level in ((True, 0), (True, 1), (False, 0), (False, 1)):
        pins.pin(5).drive(level)
        with DigitalInputDevice(5, pull_up=pull_up, pin_factory=pins) as device:
            assert device.pin.state == level
    with OutputDevice(5, pin_factory=pins):
        pins.pin(5).drive(1)
        assert not pins.pin(5).state


def test_gates_scale_the_duty_and_equal_inputs_brake() -> None:
    assert read_two_inputs(1.0, 0.0, 0.5, 1.0) == 0.5
    assert read_two_inputs(0.0, 1.0, 0.5) == -0.5
    assert read_two_inputs(1.0, 1.0, 0.5) == 0.0
