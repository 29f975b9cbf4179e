from __future__ import annotations

import math
from typing import Any

import pytest
from gpiozero import InputDevice, OutputDevice
from gpiozero.exc import PinEdgeDetectUnsupported
from gpiozero.pins.mock import MockFactory, MockPWMPin
from hypothesis import given
from hypothesis import strategies as st

from drivers.raspberrypi.encoders import QuadratureDecoder
from robotcore.errors import DescriptionError, DeviceClosedError, DeviceError
from tests.drivers.raspberrypi.encoders.wires import TURN, Wires
from tests.texts import Raises

A, B = 5, 6
PLAIN = {"driver": "quadrature", "a": A, "b": B}
PHASES = ((0, 0), (1, 0), (1, 1), (0, 1))
"""The levels of a and b after each forward edge."""


def test_a_turn_has_the_described_number_of_cycles() -> None:
    wires = Wires(PLAIN)
    turn(wires, 4 * TURN)
    assert wires.angle() == pytest.approx(math.tau)


def test_a_turn_has_the_described_number_of_edges() -> None:
    wires = Wires({**PLAIN, "counts": "edges"})
    turn(wires, TURN)
    assert wires.angle() == pytest.approx(math.tau)


def test_every_edge_counts() -> None:
    wires = Wires(PLAIN)
    angles = []
    for edge in range(4):
        turn(wires, 1, 2 + edge)
        angles.append(wires.angle())
    assert angles == pytest.approx([math.tau / TURN / 4 * edges for edges in (1, 2, 3, 4)])


def test_backward_counts_down() -> None:
    wires = Wires(PLAIN)
    turn(wires, -4 * TURN)
    assert wires.angle() == pytest.approx(-math.tau)


def test_swapping_the_channels_changes_the_sign() -> None:
    wires = Wires({**PLAIN, "a": B, "b": A})
    turn(wires, 4 * TURN)
    assert wires.angle() == pytest.approx(-math.tau)


@pytest.mark.parametrize("start", range(4))
def test_the_angle_begins_at_zero_at_every_position_of_the_wheel(start: int) -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    for number, level in zip((A, B), PHASES[start], strict=True):
        pins.pin(number).drive_high() if level else pins.pin(number).drive_low()
    wires = Wires({**PLAIN, "pull_up": False}, pins)
    assert wires.angle() == 0
    turn(wires, 1, start)
    assert wires.angle() == pytest.approx(math.tau / TURN / 4)


def test_a_wheel_that_trembles_at_an_edge_does_not_drift() -> None:
    wires = Wires(PLAIN)
    before = wires.angle()
    for _ in range(10):
        wires.set(A, 0)
        wires.set(A, 1)
    assert wires.angle() == before


@given(st.lists(st.sampled_from([1, -1]), max_size=200))
def test_the_count_is_the_sum_of_all_steps(steps: list[int]) -> None:
    decoder, phase = QuadratureDecoder(a=False, b=False), 0
    for step in steps:
        phase += step
        decoder.on_edge_a(0.0, PHASES[phase % 4][0])
        decoder.on_edge_b(0.0, PHASES[phase % 4][1])
    assert decoder.edges == sum(steps)


@given(st.integers(0, 40))
def test_a_missed_edge_costs_at_most_a_cycle(missed: int) -> None:
    decoder = QuadratureDecoder(a=False, b=False)
    for edge in range(1, 101):
        a, b = PHASES[edge % 4]
        if edge != missed:
            decoder.on_edge_a(0.0, a) if edge % 2 else decoder.on_edge_b(0.0, b)
        if edge == missed + 4:
            since = decoder.edges
    assert abs(decoder.edges - 100) <= 4
    assert decoder.edges - since == 100 - missed - 4


def test_a_sample_is_made_by_reading_and_once_at_each_time() -> None:
    wires = Wires(PLAIN)
    first = wires.encoder.read()
    turn(wires, 1)
    assert wires.encoder.read() is first
    wires.clock.sleep_until(0.5)
    second = wires.encoder.read()
    assert (second.time, second.sequence) == (0.5, 1)
    assert second.angle > first.angle == 0


@pytest.mark.parametrize("pull_up, pull", [(True, "up"), (False, "floating")])
def test_the_pull_up_follows_the_settings(pull_up: bool, pull: str) -> None:
    wires = Wires({**PLAIN, "pull_up": pull_up})
    assert [wires.pins.pin(number).pull for number in (A, B)] == [pull, pull]


def test_the_pin_debounces() -> None:
    wires = Wires({**PLAIN, "bounce_s": 0.002})
    assert [wires.pins.pin(number).bounce for number in (A, B)] == [0.002, 0.002]


class LateEdgePin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin that reports edges after its closing, as lgpio's does, unless edge detection is stopped."""

    def close(self) -> None:
        self.function = "input"


def test_closing_frees_the_pins_and_stops_counting() -> None:
    wires = Wires(PLAIN, MockFactory(pin_class=LateEdgePin))
    wires.encoder.close()
    for number in (A, B):
        assert wires.pins.pin(number).when_changed is None
        InputDevice(number, pin_factory=wires.pins).close()
    with pytest.raises(DeviceClosedError):
        wires.encoder.read()


@pytest.mark.parametrize("taken, other", [(A, B), (B, A)])
def test_a_pin_in_use_is_reported_and_the_other_is_freed(taken: int, other: int, raises: Raises) -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    with OutputDevice(taken, pin_factory=pins):
        with raises(DeviceError, "gpio-in-use"):
            Wires(PLAIN, pins)
        InputDevice(other, pin_factory=pins).close()


def test_a_pull_that_a_pin_cannot_have_is_reported_with_a_remedy(raises: Raises) -> None:
    with raises(DeviceError, "gpio-failed"):
        Wires({**PLAIN, "a": 2, "pull_up": False})


class PinWithoutEdgeDetection(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin without edge detection."""

    def _enable_event_detect(self) -> None:
        raise PinEdgeDetectUnsupported("no edges here")


def test_a_pin_without_edge_detection_is_reported_and_both_are_freed(raises: Raises) -> None:
    pins = MockFactory(pin_class=PinWithoutEdgeDetection)
    with raises(DeviceError, "gpio-failed"):
        Wires(PLAIN, pins)
    for number in (A, B):
        InputDevice(number, pin_factory=pins).close()


@pytest.mark.parametrize(
    "wrong, kind",
    [({"counts": "turns"}, "wrong-value"), ({"bounce_s": 1.0}, "out-of-bounds"), ({"a": 40}, "invalid-value")],
)
def test_invalid_settings_are_refused(wrong: dict[str, Any], kind: str, raises: Raises) -> None:
    with raises(DescriptionError, kind):
        Wires({**PLAIN, **wrong})


def turn(wires: Wires, edges: int, start: int = 2) -> None:
    """Turn by this many edges, by default from the position with both channels high."""
    sign = 1 if edges > 0 else -1
    for edge in range(start + sign, start + edges + sign, sign):
        a, b = PHASES[edge % 4]
        wires.set(A, a)
        wires.set(B, b)
