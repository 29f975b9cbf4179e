from __future__ import annotations

from collections.abc import Iterator

import pytest
from gpiozero import DigitalInputDevice, RotaryEncoder

from drivers.raspberrypi.virtual.discs import QuadratureDisc, SlottedDisc
from drivers.raspberrypi.virtual.pins import VirtualPins
from robotcore.hal.clock import SteppedClock
from tests.drivers.raspberrypi.virtual.fakes import FakeEncoder

EDGE = 0.01


@pytest.fixture
def pins() -> Iterator[VirtualPins]:
    with VirtualPins(SteppedClock(20.0, lambda steps: None)) as factory:
        yield factory


@pytest.mark.parametrize("edges", [40, -40, 43, -43])
def test_quadrature_is_counted_by_gpiozero_in_whole_cycles_and_with_its_sign(edges: int, pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = QuadratureDisc(wheel, EDGE, pins.pin(5), pins.pin(6))
    with RotaryEncoder(5, 6, max_steps=0, pin_factory=pins) as counter:
        wheel.angle = edges * EDGE
        disc.turn()
        assert counter.steps == (10 if edges > 0 else -10)


def test_quadrature_comes_back_to_where_it_was(pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = QuadratureDisc(wheel, EDGE, pins.pin(5), pins.pin(6))
    with RotaryEncoder(5, 6, max_steps=0, pin_factory=pins) as counter:
        for angle in (0.40, -0.40, 0.0):
            wheel.angle = angle
            disc.turn()
        assert counter.steps == 0


def test_one_channel_changes_with_every_edge_of_a_cycle(pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = QuadratureDisc(wheel, EDGE, pins.pin(5), pins.pin(6))
    levels = []
    for edge in range(5):
        wheel.angle = edge * EDGE
        disc.turn()
        levels.append((pins.pin(5).state, pins.pin(6).state))
    assert levels == [(True, True), (False, True), (False, False), (True, False), (True, True)]


@pytest.mark.parametrize("edges", [10, -10])
def test_slots_rise_and_fall_whatever_the_direction(edges: int, pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = SlottedDisc(wheel, EDGE, pins.pin(5))
    heard: list[bool] = []

    def note(ticks: float, is_high: bool) -> None:
        heard.append(is_high)

    with DigitalInputDevice(5, pin_factory=pins) as device:
        device.pin.when_changed = note
        wheel.angle = edges * EDGE
        disc.turn()
        device.pin.when_changed = None
    assert heard == [True, False] * 5
