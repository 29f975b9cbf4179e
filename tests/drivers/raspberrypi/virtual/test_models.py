"""Models on virtual pins: encoder discs, an ultrasonic module, motor boards."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from gpiozero import DigitalInputDevice, Motor, OutputDevice, PhaseEnableMotor, RotaryEncoder

from drivers.raspberrypi.virtual.models import (
    SILENCE_S,
    QuadratureDisc,
    SlottedDisc,
    VirtualEcho,
    VirtualPins,
    wire_phase_and_enable,
    wire_two_inputs,
)
from robotcore.hal.clock import SteppedClock
from tests.drivers.raspberrypi.virtual.fakes import FakeEncoder, FakeMotor, FakeRange

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
        disc.update()
        assert counter.steps == (10 if edges > 0 else -10)


def test_a_quadrature_disc_returns_to_its_first_count(pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = QuadratureDisc(wheel, EDGE, pins.pin(5), pins.pin(6))
    with RotaryEncoder(5, 6, max_steps=0, pin_factory=pins) as counter:
        for angle in (0.40, -0.40, 0.0):
            wheel.angle = angle
            disc.update()
        assert counter.steps == 0


def test_one_channel_changes_with_every_edge_of_a_cycle(pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = QuadratureDisc(wheel, EDGE, pins.pin(5), pins.pin(6))
    levels = []
    for edge in range(5):
        wheel.angle = edge * EDGE
        disc.update()
        levels.append((pins.pin(5).state, pins.pin(6).state))
    assert levels == [(True, True), (False, True), (False, False), (True, False), (True, True)]


@pytest.mark.parametrize("edges", [10, -10])
def test_slots_rise_and_fall_in_both_directions(edges: int, pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = SlottedDisc(wheel, EDGE, pins.pin(5))
    edges_seen: list[bool] = []

    def record_edge(ticks: float, is_high: bool) -> None:
        edges_seen.append(is_high)

    with DigitalInputDevice(5, pin_factory=pins) as device:
        device.pin.when_changed = record_edge
        wheel.angle = edges * EDGE
        disc.update()
        device.pin.when_changed = None
    assert edges_seen == [True, False] * 5


SPEED = 343.0
Edges = list[tuple[float, bool]]


class Module:
    """An ultrasonic module on its pins, and the edges of its echo line that a driver receives."""

    def __init__(self, pins: VirtualPins, clock: SteppedClock, distance: float, trigger: OutputDevice) -> None:
        self.clock, self.trigger = clock, trigger
        self.sensor = FakeRange(distance)
        self.is_lost = False
        self.edges: Edges = []
        self.model = VirtualEcho(clock, self.sensor, pins.pin(16), pins.pin(26), SPEED, lambda: self.is_lost)

    def ping(self) -> None:
        self.trigger.on()
        self.trigger.off()

    def edge(self, ticks: float, is_high: bool) -> None:
        self.edges.append((ticks, is_high))

    @property
    def pulse(self) -> float:
        (rise, is_high), (fall, is_still_high) = self.edges
        assert (is_high, is_still_high) == (True, False)
        return fall - rise


@contextmanager
def module(distance: float) -> Iterator[Module]:
    clock = SteppedClock(20.0, lambda steps: None)
    with (
        VirtualPins(clock) as pins,
        OutputDevice(16, pin_factory=pins) as trigger,
        DigitalInputDevice(26, pin_factory=pins) as echo,
    ):
        made = Module(pins, clock, distance, trigger)
        echo.pin.when_changed = made.edge
        yield made


@pytest.mark.parametrize("distance", [0.02, 0.5, 4.3])
def test_the_pulse_has_the_length_of_the_sound_s_travel_time(distance: float) -> None:
    with module(distance) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        nose.clock.sleep_until(1.1)
        assert nose.pulse == pytest.approx(2 * distance / SPEED, abs=1e-9)
        assert nose.edges[0][0] == pytest.approx(1.00045)


def test_without_an_echo_the_pulse_is_the_module_s_time_out() -> None:
    with module(math.inf) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        nose.clock.sleep_until(1.1)
        assert nose.pulse == pytest.approx(SILENCE_S)


def test_no_edge_comes_before_its_exact_time() -> None:
    with module(1.7) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        assert nose.edges == []
        nose.clock.sleep_until(1.005)
        assert len(nose.edges) == 1


def test_both_edges_come_at_once_while_the_robot_opens() -> None:
    with module(0.5) as nose:
        nose.ping()
        nose.ping()
        assert nose.edges[:2] == nose.edges[2:]
        assert nose.edges[1][0] - nose.edges[0][0] == pytest.approx(1.0 / SPEED)


def test_a_trigger_during_the_echo_is_ignored() -> None:
    with module(1.7) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        nose.sensor.distance = 0.1
        nose.ping()
        nose.clock.sleep_until(1.1)
        assert nose.pulse == pytest.approx(2 * 1.7 / SPEED)


def test_after_a_lost_echo_the_next_one_is_measured() -> None:
    with module(0.5) as nose:
        nose.clock.sleep_until(1.0)
        nose.is_lost = True
        nose.ping()
        nose.clock.sleep_until(1.1)
        assert nose.pulse == pytest.approx(SILENCE_S)
        nose.edges.clear()
        nose.is_lost = False
        nose.ping()
        nose.clock.sleep_until(1.2)
        assert nose.pulse == pytest.approx(1.0 / SPEED)


def scale_by_ten(duty: float) -> float:
    return 10 * duty


@pytest.mark.parametrize("duty", [0.5, -0.25, 0.0])
def test_two_inputs_turn_the_wheel_at_once(duty: float, pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_two_inputs(wheel, scale_by_ten, pins.pin(17), pins.pin(27))
    with Motor(17, 27, pin_factory=pins) as motor:
        motor.value = duty
        assert wheel.velocity == pytest.approx(10 * duty)
    assert wheel.velocity == 0


@pytest.mark.parametrize("duty", [0.5, -0.25, 0.0])
def test_phase_and_enable_turn_the_wheel_at_once(duty: float, pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_phase_and_enable(wheel, scale_by_ten, pins.pin(17), pins.pin(27))
    with PhaseEnableMotor(17, 27, pin_factory=pins) as motor:
        motor.value = duty
        assert wheel.velocity == pytest.approx(10 * duty)
    assert wheel.velocity == 0


def test_wheel_stands_while_its_bridge_is_not_enabled(pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_two_inputs(wheel, scale_by_ten, pins.pin(17), pins.pin(27), pins.pin(22))
    with Motor(17, 27, pin_factory=pins) as motor:
        motor.value = 0.5
        assert wheel.velocity == 0
        with OutputDevice(22, initial_value=True, pin_factory=pins):
            assert wheel.velocity == 5
        assert wheel.velocity == 0


def test_equal_inputs_brake(pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_two_inputs(wheel, scale_by_ten, pins.pin(17), pins.pin(27))
    with OutputDevice(17, initial_value=True, pin_factory=pins), OutputDevice(27, pin_factory=pins) as backward:
        assert wheel.velocity == 10
        backward.on()
        assert wheel.velocity == 0
