from __future__ import annotations

from collections.abc import Iterator

import pytest
from gpiozero import DigitalInputDevice, GPIOPinInUse, OutputDevice, PWMOutputDevice

from drivers.raspberrypi.virtual.models import VirtualPins
from robotcore.hal.clock import SteppedClock


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock(20.0, lambda steps: None)


@pytest.fixture
def pins(clock: SteppedClock) -> Iterator[VirtualPins]:
    with VirtualPins(clock) as factory:
        yield factory


def test_ticks_are_simulated_time(clock: SteppedClock, pins: VirtualPins) -> None:
    before = pins.ticks()
    clock.sleep_until(1.5)
    assert pins.ticks_diff(pins.ticks(), before) == 1.5


@pytest.mark.parametrize("asked, sent", [(0.37, 0.37), (0.379, 0.37), (0.29, 0.28), (1.0, 1.0), (0.0, 0.0)])
def test_duty_is_cut_to_whole_percent_as_lgpio_does_it(asked: float, sent: float, pins: VirtualPins) -> None:
    with PWMOutputDevice(17, pin_factory=pins) as output:
        output.value = asked
        assert pins.pin(17).state == sent


def test_a_listener_is_called_at_every_change_and_only_then(pins: VirtualPins) -> None:
    edges_seen: list[float] = []
    pin = pins.pin(17)
    pin.on_change(lambda: edges_seen.append(pin.state))
    with PWMOutputDevice(17, pin_factory=pins) as output:
        for value in (0.5, 0.5, 0.25):
            output.value = value
    assert edges_seen == [0.5, 0.25, 0.0]


def test_a_closed_pin_falls_low(pins: VirtualPins) -> None:
    output = OutputDevice(17, initial_value=True, pin_factory=pins)
    output.close()
    assert not pins.pin(17).state


def test_closing_the_factory_lets_every_pin_fall(clock: SteppedClock) -> None:
    pins = VirtualPins(clock)
    pin = pins.pin(17)
    output = OutputDevice(17, initial_value=True, pin_factory=pins)
    pins.close()
    assert not pin.state
    output.close()


def test_an_edge_from_outside_has_its_ticks(clock: SteppedClock, pins: VirtualPins) -> None:
    edges: list[tuple[float, bool]] = []

    def record_edge(ticks: float, is_high: bool) -> None:
        edges.append((ticks, is_high))

    with DigitalInputDevice(5, pin_factory=pins) as device:
        device.pin.when_changed = record_edge
        clock.sleep_until(0.5)
        pins.pin(5).drive(1, 0.4321)
        pins.pin(5).drive(1)
        pins.pin(5).drive(0)
        device.pin.when_changed = None
    assert edges == [(0.4321, True), (0.5, False)]


@pytest.mark.parametrize("pull_up", [True, False])
@pytest.mark.parametrize("level", [0, 1])
def test_a_driven_level_overrides_the_pull(level: int, pull_up: bool, pins: VirtualPins) -> None:
    pins.pin(5).drive(level)
    with DigitalInputDevice(5, pull_up=pull_up, pin_factory=pins) as device:
        assert device.pin.state == level


def test_an_output_ignores_levels_from_outside(pins: VirtualPins) -> None:
    with OutputDevice(5, pin_factory=pins):
        pins.pin(5).drive(1)
        assert not pins.pin(5).state


def test_pin_in_use_is_refused_and_free_again_after_closing(pins: VirtualPins) -> None:
    with OutputDevice(17, pin_factory=pins), pytest.raises(GPIOPinInUse):
        OutputDevice(17, pin_factory=pins)
    OutputDevice(17, pin_factory=pins).close()


def test_robots_do_not_share_pins(clock: SteppedClock, pins: VirtualPins) -> None:
    with VirtualPins(clock) as other, OutputDevice(17, pin_factory=pins) as one, OutputDevice(17, pin_factory=other):
        one.on()
        assert (pins.pin(17).state, other.pin(17).state) == (True, False)


def test_gpiozero_s_default_factory_is_unchanged(pins: VirtualPins) -> None:
    from gpiozero import Device

    before = Device.pin_factory
    OutputDevice(17, pin_factory=pins).close()
    assert Device.pin_factory is before
