"""Virtual pins, and the models on them: encoder discs, an ultrasonic module, motor boards."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from gpiozero import Device, DigitalInputDevice, Motor, OutputDevice, PhaseEnableMotor, PWMOutputDevice, RotaryEncoder

from drivers.raspberrypi.virtual.models import (
    QUADRATURE,
    SILENCE_S,
    SLOTS,
    Disc,
    VirtualEcho,
    VirtualPins,
    read_phase_and_enable,
    read_two_inputs,
    wire_motor,
)
from robotcore.hal.clock import SteppedClock
from robotcore.hardware.motor_model import MotorModel
from tests.drivers.raspberrypi.virtual.fakes import FakeEncoder, FakeMotor, FakeRange

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


def test_a_listener_is_called_at_every_change_and_only_then(pins: VirtualPins) -> None:
    levels: list[float] = []
    pins.pin(17).on_change(lambda: levels.append(pins.pin(17).state))
    with PWMOutputDevice(17, pin_factory=pins) as output:
        for value in (0.5, 0.5, 0.25):
            output.value = value
    assert levels == [0.5, 0.25, 0.0]


def test_closing_the_factory_lets_every_pin_fall(clock: SteppedClock) -> None:
    pins = VirtualPins(clock)
    output = OutputDevice(17, initial_value=True, pin_factory=pins)
    pin = pins.pin(17)
    pins.close()
    assert not pin.state
    output.close()


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


def test_robots_share_no_pins_and_gpiozero_s_default_factory_is_unchanged(
    clock: SteppedClock, pins: VirtualPins
) -> None:
    before = Device.pin_factory
    with VirtualPins(clock) as other, OutputDevice(17, pin_factory=pins) as one, OutputDevice(17, pin_factory=other):
        one.on()
        assert (pins.pin(17).state, other.pin(17).state) == (True, False)
    assert Device.pin_factory is before


@pytest.mark.parametrize("angles, steps", [([43 * EDGE], 10), ([-43 * EDGE], -10), ([0.40, -0.40, 0.0], 0)])
def test_gpiozero_counts_the_whole_cycles_of_a_quadrature_disc_with_their_sign(
    angles: list[float], steps: int, pins: VirtualPins
) -> None:
    wheel = FakeEncoder()
    disc = Disc(wheel, EDGE, QUADRATURE, [pins.pin(5), pins.pin(6)])
    with RotaryEncoder(5, 6, max_steps=0, pin_factory=pins) as counter:
        for angle in angles:
            wheel.angle = angle
            disc.update()
        assert counter.steps == steps


@pytest.mark.parametrize("edges", [10, -10])
def test_slots_rise_and_fall_in_both_directions(edges: int, pins: VirtualPins) -> None:
    wheel = FakeEncoder()
    disc = Disc(wheel, EDGE, SLOTS, [pins.pin(5)])
    with record_edges(5, pins) as seen:
        wheel.angle = edges * EDGE
        disc.update()
    assert [is_high for _, is_high in seen] == [True, False] * 5


SPEED = 343.0


class Module:
    """An ultrasonic module on its pins, and the edges of its echo line that a driver receives."""

    def __init__(self, pins: VirtualPins, clock: SteppedClock, trigger: OutputDevice) -> None:
        self.clock, self.trigger = clock, trigger
        self.sensor = FakeRange(1.7)
        self.is_lost = False
        self.edges: list[tuple[float, bool]] = []
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
        made = Module(pins, clock, trigger)
        made.edges = edges
        yield made


def test_the_pulse_has_the_length_of_the_sound_s_travel_time_or_of_the_time_out(nose: Module) -> None:
    nose.clock.sleep_until(1.0)
    for distance in (0.02, 0.5, 4.3):
        nose.sensor.distance = distance
        nose.ping()
        assert nose.pulse() == pytest.approx(2 * distance / SPEED, abs=1e-9)
    nose.is_lost = True
    nose.ping()
    assert nose.pulse() == pytest.approx(SILENCE_S)
    nose.is_lost, nose.sensor.distance = False, math.inf
    nose.ping()
    assert nose.pulse() == pytest.approx(SILENCE_S)


def test_no_edge_comes_before_its_exact_time_and_a_trigger_during_the_echo_is_ignored(nose: Module) -> None:
    nose.clock.sleep_until(1.0)
    nose.ping()
    assert nose.edges == []
    nose.clock.sleep_until(1.005)
    assert [ticks for ticks, _ in nose.edges] == pytest.approx([1.00045])
    nose.sensor.distance = 0.1
    nose.ping()
    assert nose.pulse() == pytest.approx(2 * 1.7 / SPEED)


def test_both_edges_come_at_once_while_the_robot_opens(nose: Module) -> None:
    nose.ping()
    nose.ping()
    assert nose.edges[:2] == nose.edges[2:]
    assert nose.edges[1][0] - nose.edges[0][0] == pytest.approx(2 * 1.7 / SPEED)


MODEL = MotorModel(forward_rad_s=10.0, backward_rad_s=10.0)


@pytest.mark.parametrize(
    "duty, board", [(read_two_inputs, Motor), (read_phase_and_enable, PhaseEnableMotor)], ids=["two inputs", "phase"]
)
def test_a_board_turns_the_wheel_at_once(duty: Callable[..., float], board: type[Motor], pins: VirtualPins) -> None:
    wheel = FakeMotor()
    wire_motor(wheel, MODEL, [pins.pin(17), pins.pin(27)], duty)
    with board(17, 27, pin_factory=pins) as motor:
        for value in (0.5, -0.25, 0.0, 0.5):
            motor.value = value
            assert wheel.velocity == pytest.approx(10 * value)
    assert wheel.velocity == 0


def test_gates_scale_the_duty_and_equal_inputs_brake() -> None:
    assert read_two_inputs(1.0, 0.0, 0.5, 1.0) == 0.5
    assert read_two_inputs(0.0, 1.0, 0.5) == -0.5
    assert read_two_inputs(1.0, 0.0, 0.5, 0.0) == 0.0
    assert read_two_inputs(1.0, 1.0, 0.5) == 0.0
