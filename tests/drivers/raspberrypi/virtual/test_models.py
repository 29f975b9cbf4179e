"""Virtual pins, and the models on them: encoder discs, an ultrasonic module, motor boards."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from gpiozero import DigitalInputDevice, OutputDevice, PWMOutputDevice

from drivers.raspberrypi.virtual.models import (
    SILENCE_S,
    VirtualEcho,
    VirtualPins,
    read_two_inputs,
)
from robotcore.hal.clock import SteppedClock
from tests.drivers.raspberrypi.ranging.modules import FakeRange

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


SPEED = 343.0


class Module:
    """An ultrasonic module, and the edges of its echo line that a driver receives."""

    def __init__(
        self, pins: VirtualPins, clock: SteppedClock, trigger: OutputDevice, edges: list[tuple[float, bool]]
    ) -> None:
        self.clock, self.trigger, self.edges = clock, trigger, edges
        self.sensor = FakeRange(1.7)
        self.is_lost = False
        self.model = VirtualEcho(clock, self.sensor, pins.pin(16), pins.pin(26), SPEED, lambda: self.is_lost)

    def ping(self) -> None:
        self.trigger.on()
        self.trigger.off()

    def pulse(self) -> float:
        """Return the length of the only pulse since the last call."""
        self.clock.sleep_until(self.clock.now() + 0.1)
        (rise, is_high), (fall, is_still_high) = self.edges
        assert (is_high, is_still_high) == (True, False)
        self.edges.clear()
        return fall - rise


@pytest.fixture
def nose(pins: VirtualPins, clock: SteppedClock) -> Iterator[Module]:
    with OutputDevice(16, pin_factory=pins) as trigger, record_edges(26, pins) as edges:
        yield Module(pins, clock, trigger, edges)


@pytest.mark.parametrize(
    "distance, is_lost, seconds",
    [(0.02, False, 0.04 / SPEED), (4.3, False, 8.6 / SPEED), (math.inf, False, SILENCE_S), (0.5, True, SILENCE_S)],
)
def test_the_pulse_has_the_length_of_the_sound_s_travel_time_or_of_the_time_out(
    distance: float, is_lost: bool, seconds: float, nose: Module
) -> None:
    nose.clock.sleep_until(1.0)
    nose.sensor.distance, nose.is_lost = distance, is_lost
    nose.ping()
    assert nose.pulse() == pytest.approx(seconds, abs=1e-9)


def test_no_edge_comes_before_its_exact_time_and_a_trigger_during_the_echo_is_ignored(nose: Module) -> None:
    nose.clock.sleep_until(1.0)
    nose.ping()
    assert nose.edges == []
    nose.clock.sleep_until(1.005)
    assert [ticks for ticks, _ in nose.edges] == pytest.approx([1.00045])
    nose.ping()
    assert nose.pulse() == pytest.approx(2 * 1.7 / SPEED)


def test_gates_scale_the_duty_and_equal_inputs_brake() -> None:
    assert read_two_inputs(1.0, 0.0, 0.5, 1.0) == 0.5
    assert read_two_inputs(0.0, 1.0, 0.5) == -0.5
    assert read_two_inputs(1.0, 1.0, 0.5) == 0.0
