from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from gpiozero import DigitalInputDevice, OutputDevice

from drivers.raspberrypi.virtual.echo import SILENCE_S, VirtualEcho
from drivers.raspberrypi.virtual.pins import VirtualPins
from robotcore.hal.clock import SteppedClock
from tests.drivers.raspberrypi.virtual.fakes import FakeRange

SPEED = 343.0
Edges = list[tuple[float, bool]]


class Module:
    """A module on its pins, with the edges of its echo as a driver gets them."""

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
def test_pulse_is_as_long_as_sound_takes_there_and_back(distance: float) -> None:
    with module(distance) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        nose.clock.sleep_until(1.1)
        assert nose.pulse == pytest.approx(2 * distance / SPEED, abs=1e-9)
        assert nose.edges[0][0] == pytest.approx(1.00045)


def test_silence_is_the_module_s_own_time_out() -> None:
    with module(math.inf) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        nose.clock.sleep_until(1.1)
        assert nose.pulse == pytest.approx(SILENCE_S)


def test_no_edge_comes_before_its_time() -> None:
    with module(1.7) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        assert nose.edges == []
        nose.clock.sleep_until(1.005)
        assert len(nose.edges) == 1


def test_before_time_begins_both_edges_come_at_once_as_often_as_asked() -> None:
    with module(0.5) as nose:
        nose.ping()
        nose.ping()
        assert nose.edges[:2] == nose.edges[2:]
        assert nose.edges[1][0] - nose.edges[0][0] == pytest.approx(1.0 / SPEED)


def test_trigger_is_ignored_while_the_echo_is_out() -> None:
    with module(1.7) as nose:
        nose.clock.sleep_until(1.0)
        nose.ping()
        nose.sensor.distance = 0.1
        nose.ping()
        nose.clock.sleep_until(1.1)
        assert nose.pulse == pytest.approx(2 * 1.7 / SPEED)


def test_lost_echo_is_silence_and_the_next_one_is_heard() -> None:
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
