"""The controller of a motor's velocity, without a motor."""

from __future__ import annotations

import math

import pytest

from robotcore.hardware.motor_control import Control, VelocityControl
from robotcore.hardware.motor_model import MotorModel

MODEL = MotorModel(dead_band=0.1, forward_rad_s=14.0, backward_rad_s=14.0)
TARGET, PERIOD_S, LAG_S = 6.0, 0.05, 0.2


def build_control(lag: float = LAG_S) -> VelocityControl:
    return VelocityControl(Control(), MODEL, lag, counts_per_turn=960)


def test_wheel_that_turns_as_expected_is_not_corrected() -> None:
    control = build_control()
    for step in range(20):
        time = step * PERIOD_S
        angle = TARGET * (time - LAG_S * (1 - math.exp(-time / LAG_S)))
        assert control.update(TARGET, angle, time) == pytest.approx(TARGET)


def test_wheel_that_lags_behind_is_sent_a_greater_velocity() -> None:
    control = build_control(lag=0.0)
    control.update(TARGET, 0.0, 0.0)
    assert control.update(TARGET, 0.5 * TARGET * PERIOD_S, PERIOD_S) > TARGET


def test_restarted_control_forgets_its_correction() -> None:
    control = build_control(lag=0.0)
    for step in range(5):
        control.update(TARGET, 0.0, step * PERIOD_S)
    assert control.start(TARGET) > TARGET
    control.restart()
    assert control.start(TARGET) == TARGET
