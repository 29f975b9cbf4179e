from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from gpiozero import Motor

from tests.system.guest.chip import Chip
from tests.system.guest.waiting import settled

FORWARD, BACKWARD = 17, 27


@pytest.fixture
def motor(pins: Any) -> Iterator[Motor]:
    with Motor(FORWARD, BACKWARD, pin_factory=pins) as made:
        yield made


def test_forward_drives_the_forward_pin_alone(chip: Chip, motor: Motor) -> None:
    motor.forward()
    assert settled(chip.high, [FORWARD]) == [FORWARD]


def test_backward_drives_the_backward_pin_alone(chip: Chip, motor: Motor) -> None:
    motor.backward()
    assert settled(chip.high, [BACKWARD]) == [BACKWARD]


def test_stop_leaves_every_pin_low(chip: Chip, motor: Motor) -> None:
    motor.forward()
    motor.stop()
    assert settled(chip.high, []) == []


def test_half_the_duty_is_high_about_half_the_time(chip: Chip, motor: Motor) -> None:
    motor.forward(0.5)
    samples = [chip.level(FORWARD) for _ in range(4000)]
    assert 0.3 < sum(samples) / len(samples) < 0.7
