"""Encoders on mock pins: with two channels, and with one."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

import pytest
from gpiozero import InputDevice, OutputDevice
from gpiozero.pins.mock import MockFactory, MockPWMPin
from hypothesis import given
from hypothesis import strategies as st

from drivers.raspberrypi.encoders import EdgeCounter, PinEncoder, QuadratureDecoder
from robotcore.errors import DescriptionError, DeviceClosedError, DeviceError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import bind_devices
from robotcore.kinds.encoder import Angle
from tests.drivers.raspberrypi.motors.rig import Rig, rover
from tests.texts import Raises

A, B = 5, 6
QUADRATURE = {"driver": "quadrature", "a": A, "b": B}
PULSES = {"driver": "pulses", "gpio": A}
PHASES = ((1, 1), (0, 1), (0, 0), (1, 0))
"""The levels of a and b after each forward edge."""

TURN = 24
"""The described counts in a turn."""

EDGE = math.tau / TURN / 4


def open_encoder(section: Mapping[str, Any] = QUADRATURE, **options: Any) -> Rig:
    """Open the left encoder of a rover, whose motor is not open."""
    return Rig(encoder=section, slots=TURN, names=("left_encoder",), **options)


def read_angle(rig: Rig) -> float:
    """Return the angle at the next instant, in rad."""
    rig.pass_time(rig.clock.step)
    return rig.encoder.read().angle


@pytest.mark.parametrize(
    "changed, edges, angle",
    [
        ({}, 4 * TURN, math.tau),
        ({}, -4 * TURN, -math.tau),
        ({"counts": "edges"}, TURN, math.tau),
        ({"a": B, "b": A}, 4 * TURN, -math.tau),
        *(({}, edges, edges * EDGE) for edges in (1, 2, 3, 5)),
    ],
)
def test_every_edge_of_two_channels_counts_with_its_direction(
    changed: dict[str, Any], edges: int, angle: float
) -> None:
    rig = open_encoder({**QUADRATURE, **changed})
    rig.turn_to(edges * EDGE)
    assert read_angle(rig) == pytest.approx(angle)


@pytest.mark.parametrize("start", range(4))
def test_the_angle_begins_at_zero_at_every_position_of_the_wheel(start: int) -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    for number, level in zip((A, B), PHASES[start], strict=True):
        pins.pin(number).drive_high() if level else pins.pin(number).drive_low()
    rig = open_encoder({**QUADRATURE, "pull_up": False}, pins=pins)
    rig.angle = start * EDGE
    assert read_angle(rig) == 0
    rig.turn_to((start + 1) * EDGE)
    assert read_angle(rig) == pytest.approx(EDGE)


@given(st.integers(0, 40))
def test_a_missed_edge_costs_at_most_a_cycle(missed: int) -> None:
    decoder = QuadratureDecoder(a=True, b=True)
    for edge in range(1, 101):
        a, b = PHASES[edge % 4]
        if edge != missed:
            decoder.on_edge_a(0.0, a) if edge % 2 else decoder.on_edge_b(0.0, b)
        if edge == missed + 4:
            since = decoder.edges
    assert abs(decoder.edges - 100) <= 4
    assert decoder.edges - since == 100 - missed - 4


def test_a_sample_is_made_by_reading_and_once_at_each_time() -> None:
    rig = open_encoder()
    first = rig.encoder.read()
    rig.turn_to(EDGE)
    assert rig.encoder.read() is first
    rig.clock.sleep_until(0.5)
    second = rig.encoder.read()
    assert (second.time, second.sequence) == (0.5, 1)
    assert second.angle > first.angle == 0


@pytest.mark.parametrize("pull_up, pull", [(True, "up"), (False, "floating")])
def test_the_pull_up_and_the_debounce_time_follow_the_settings(pull_up: bool, pull: str) -> None:
    rig = open_encoder({**QUADRATURE, "pull_up": pull_up, "bounce_s": 0.002})
    pins = [rig.pins.pin(number) for number in (A, B)]
    assert [(pin.pull, pin.bounce) for pin in pins] == [(pull, 0.002)] * 2


class LateEdgePin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin that reports edges after its closing, as lgpio's does, unless edge detection is stopped."""

    def close(self) -> None:
        self.function = "input"


def test_closing_frees_the_pins_and_stops_counting() -> None:
    rig = open_encoder(pin_class=LateEdgePin)
    rig.encoder.close()
    for number in (A, B):
        assert rig.pins.pin(number).when_changed is None
        InputDevice(number, pin_factory=rig.pins).close()
    with pytest.raises(DeviceClosedError):
        rig.encoder.read()


@pytest.mark.parametrize("taken, other", [(A, B), (B, A)])
def test_a_pin_in_use_is_reported_and_the_other_is_freed(taken: int, other: int, raises: Raises) -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    with OutputDevice(taken, pin_factory=pins):
        with raises(DeviceError, "gpio-in-use"):
            open_encoder(pins=pins)
        InputDevice(other, pin_factory=pins).close()


class SlowCounter(EdgeCounter):
    """A counter whose first reading blocks."""

    def __init__(self) -> None:
        self.is_read, self.release = threading.Event(), threading.Event()

    @property
    def edges(self) -> int:  # type: ignore[override]
        if not self.is_read.is_set():
            self.is_read.set()
            self.release.wait(10.0)
        return 0


def test_threads_that_read_at_once_get_samples_of_one_row() -> None:
    clock, counter, samples = MonotonicClock(), SlowCounter(), list[Angle]()
    encoder = PinEncoder("left_encoder", clock, counter, 4, ExitStack())
    threads = [threading.Thread(target=lambda: samples.append(encoder.read())) for _ in range(2)]
    threads[0].start()
    assert counter.is_read.wait(10.0)
    threads[1].start()
    threads[1].join(0.05)  # enough for a thread that is not blocked
    counter.release.set()
    for thread in threads:
        thread.join(10.0)
    clock.close()
    assert [sample.sequence for sample in sorted(samples, key=lambda sample: sample.time)] == [0, 1]


@pytest.mark.parametrize("counts, turns", [("cycles", 1), ("edges", 2)])
def test_every_edge_of_one_channel_counts(counts: str, turns: int) -> None:
    rig = open_encoder({**PULSES, "counts": counts})
    rig.turn_to(math.tau)
    assert read_angle(rig) == pytest.approx(turns * math.tau)


def test_one_channel_counts_in_the_direction_of_the_motors_last_command() -> None:
    rig = Rig(encoder=PULSES, slots=TURN, wheel={"dead_band": 0.99})  # only the test turns the wheel
    angles = []
    for command in (-3.0, 3.0, 0.0, -3.0):  # a stopped wheel coasts
        rig.motor.set_velocity(command)
        rig.turn_to(rig.angle + 4 * EDGE)
        angles.append(read_angle(rig))
    assert angles == pytest.approx([-4 * EDGE, 0, 4 * EDGE, 0])


def test_an_encoder_with_one_channel_on_no_wheel_of_the_drive_is_refused(raises: Raises) -> None:
    robot = rover({"left_encoder": PULSES}).model_copy(update={"drive": None})
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(robot, "raspberrypi", ["left_encoder"])
