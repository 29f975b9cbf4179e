from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import pytest

from robotcore.kinds.motor import Motor
from tests.system.guest.bench import open_device, wait_until
from tests.system.guest.chip import Chip

FORWARD, BACKWARD = 17, 27
FULL_RAD_S = 12.0


@pytest.fixture
def motor(pins: Any) -> Iterator[Motor]:
    opened = cast("Motor", open_device("left_motor", pins))
    yield opened
    opened.close()


def share_high(chip: Chip, gpio: int) -> float:
    """Return the share of samples in which a line is high, which approximates its duty."""
    samples = [chip.level(gpio) for _ in range(4000)]
    return sum(samples) / len(samples)


def test_full_speed_forward_holds_the_forward_pin_high_and_no_other(chip: Chip, motor: Motor) -> None:
    motor.set_velocity(FULL_RAD_S)
    assert wait_until(chip.high, [FORWARD]) == [FORWARD]


def test_full_speed_backward_holds_the_backward_pin_high_and_no_other(chip: Chip, motor: Motor) -> None:
    motor.set_velocity(-FULL_RAD_S)
    assert wait_until(chip.high, [BACKWARD]) == [BACKWARD]


def test_a_stop_leaves_every_pin_low(chip: Chip, motor: Motor) -> None:
    motor.set_velocity(FULL_RAD_S)
    wait_until(chip.high, [FORWARD])
    motor.stop()
    assert wait_until(chip.high, []) == []


@pytest.mark.parametrize("share", [0.25, 0.75])
def test_a_share_of_the_speed_is_that_share_of_the_duty(chip: Chip, motor: Motor, share: float) -> None:
    motor.set_velocity(share * FULL_RAD_S)
    assert share_high(chip, FORWARD) == pytest.approx(share, abs=0.15)
    assert chip.level(BACKWARD) == 0


def test_closing_leaves_every_pin_low(chip: Chip, motor: Motor) -> None:
    motor.set_velocity(FULL_RAD_S)
    wait_until(chip.high, [FORWARD])
    motor.close()
    assert wait_until(chip.high, []) == []


def test_closing_leaves_every_pin_pulled_down(chip: Chip, pins: Any) -> None:
    for gpio in (FORWARD, BACKWARD):
        chip.pull(gpio, 1)
    open_device("left_motor", pins).close()
    pins.close()
    assert [chip.file(gpio, "pull").read_text().strip() for gpio in (FORWARD, BACKWARD)] == ["pull-down"] * 2
