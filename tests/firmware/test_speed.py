from __future__ import annotations

import re
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.hardware.firmware.board import shipped_sketch
from tests.firmware.host import Firmware, Motor, run_motor

ROS_ARDUINO_BRIDGE = (20, 12, 0, 50)

SLOW, COMMON, FAST = Motor(53, 0.06, 45), Motor(71, 0.05, 25), Motor(176, 0.08, 45)
"""Gear motors of 12 V with 960 counts a turn: 100, 133 and 330 turns a minute."""


def shipped_gains() -> tuple[int, int, int, int]:
    gains = dict(re.findall(r"#define (K[PDIO]) (\d+)", (shipped_sketch() / "config.h").read_text()))
    return int(gains["KP"]), int(gains["KD"]), int(gains["KI"]), int(gains["KO"])


def test_common_motors_reach_their_speed_within_1_5_s_and_keep_it(firmware: Firmware) -> None:
    for case in product([shipped_gains(), ROS_ARDUINO_BRIDGE], [SLOW, COMMON, FAST], [3, 20, 40, -3, -30]):
        gains, motor, target = case
        control = firmware.speed_control(gains)
        control.set_target(target)
        speeds = run_motor(replace(motor), control.step, 120)
        assert speeds[45:] == pytest.approx([target] * 75, abs=max(1.0, 0.08 * abs(target))), case
        assert sum(speeds[60:]) / 60 == pytest.approx(target, abs=0.3), case


def test_new_target_causes_no_derivative_kick(firmware: Firmware) -> None:
    control = firmware.speed_control((0, 1000, 0, 1))
    control.set_target(20)
    control.step(0)
    before = control.step(0)
    control.set_target(40)
    assert before == pytest.approx(20 + 20 * 235 / 176, abs=1)
    assert control.step(0) == pytest.approx(20 + 40 * 235 / 176, abs=1)


@pytest.mark.parametrize("gains", [shipped_gains(), (30, 40, 1, 50)], ids=["shipped", "with ki"])
def test_blocked_wheel_does_not_overshoot_after_its_release(
    firmware: Firmware, gains: tuple[int, int, int, int]
) -> None:
    control = firmware.speed_control(gains)
    control.set_target(20)
    held = [control.step(0) for _ in range(300)]
    assert held[-1] == 255
    speeds = run_motor(replace(COMMON), control.step, 120)
    assert max(speeds) < 71 / 2 + 20
    assert speeds[60:] == pytest.approx([20] * 60, abs=2)


def test_small_errors_are_not_lost(firmware: Firmware) -> None:
    control = firmware.speed_control((1, 0, 0, 100))
    control.set_target(1)
    first = control.step(0)
    assert max(control.step(0) for _ in range(400)) >= first + 3


@given(
    gains=st.tuples(*[st.integers(0, 1000)] * 3, st.integers(1, 1000)),
    steps=st.lists(st.tuples(st.integers(-1000, 1000), st.integers(-(2**31), 2**31 - 1)), max_size=40),
)
def test_duty_never_opposes_the_target_and_is_0_for_target_0(
    firmware: Firmware, gains: tuple[int, int, int, int], steps: list[tuple[int, int]]
) -> None:
    control = firmware.speed_control(gains)
    for target, counts in steps:
        control.set_target(target)
        duty = control.step(counts)
        assert abs(duty) <= 255
        assert duty * target >= 0
        assert target != 0 or duty == 0


def test_change_of_direction_resets_the_controller(firmware: Firmware) -> None:
    control, fresh = firmware.speed_control(shipped_gains()), firmware.speed_control(shipped_gains())
    control.set_target(20)
    for _ in range(30):
        control.step(0)
    control.set_target(-20)
    fresh.set_target(-20)
    assert control.step(0) == fresh.step(0)


def test_integral_that_stopped_a_wheel_lets_it_turn_again(firmware: Firmware) -> None:
    control = firmware.speed_control((0, 0, 10, 50))
    control.set_target(20)
    for _ in range(30):
        control.step(60)
    assert control.step(60) == 0
    assert any(control.step(0) > 100 for _ in range(60))
