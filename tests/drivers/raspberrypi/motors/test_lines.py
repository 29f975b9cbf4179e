"""Motors on lgpio's PWM, in a process that is suspended right after a command."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.raspberrypi.motors.driver import round_to_percent
from drivers.raspberrypi.pins import open_pins
from tests.drivers.raspberrypi.lines import Lines
from tests.drivers.raspberrypi.lines import lgpio as ours
from tests.drivers.raspberrypi.motors.rig import BACKWARD, FORWARD, H_BRIDGE, MODEL, Rig

PHASE_ENABLE = {"driver": "phase-enable", "phase": BACKWARD, "enable": FORWARD, "model": dict(MODEL)}


@pytest.fixture
def lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Lines:
    monkeypatch.setenv("FAKE_DEV", str(tmp_path))
    monkeypatch.setitem(sys.modules, "lgpio", ours)
    monkeypatch.delitem(sys.modules, "gpiozero.pins.lgpio", raising=False)
    monkeypatch.setattr("gpiozero.pins.local.get_pi_revision", lambda: 0xA02082)
    return Lines(tmp_path)


@pytest.fixture
def pins(lines: Lines) -> Iterator[Any]:
    made = open_pins("lgpio")
    yield made
    made.close()


@pytest.mark.parametrize("board", [H_BRIDGE, PHASE_ENABLE])
def test_a_stop_is_low_at_once_and_the_next_command_turns_again(
    board: Mapping[str, Any], lines: Lines, pins: Any
) -> None:
    motor = Rig(board, pins=pins, names=("left_motor",)).motor
    for _ in range(2):
        motor.set_velocity(7.0)
        assert lines.level(FORWARD) == 55
        motor.stop()
        assert lines.level(FORWARD) == 0
    motor.close()


def test_turning_the_other_way_never_has_both_inputs_high(lines: Lines, pins: Any) -> None:
    motor = Rig(pins=pins, names=("left_motor",)).motor
    motor.set_velocity(7.0)
    motor.set_velocity(-7.0)
    assert (lines.level(FORWARD), lines.level(BACKWARD)) == (0, 55)
    motor.close()


def test_lgpio_sends_exactly_the_whole_percent() -> None:
    for percent in range(-100, 101):
        duty = round_to_percent(percent / 100)
        assert int(duty * 100) == percent
        assert duty == pytest.approx(percent / 100), percent
        assert abs(duty) <= 1, percent


@given(st.floats(-1, 1))
def test_a_duty_is_rounded_to_the_nearest_percent(duty: float) -> None:
    assert abs(round_to_percent(duty) - duty) <= 0.005 + 1e-12
