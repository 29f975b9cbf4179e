from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from robotcore.hardware.motor_model import MotorModel

models = st.builds(
    MotorModel,
    dead_band=st.floats(0, 0.8),
    forward_rad_s=st.floats(0.5, 100),
    backward_rad_s=st.floats(0.5, 100),
    max_duty=st.floats(0.1, 1),
)


@given(models, st.floats(-1, 1))
def test_duty_and_velocity_are_inverse(model: MotorModel, share: float) -> None:
    velocity = share * model.reach(share)
    assert model.velocity(model.duty(velocity)) == pytest.approx(velocity, rel=1e-9, abs=1e-9)


@given(models, st.floats(-1000, 1000))
def test_duty_is_limited_and_has_the_sign_of_its_velocity(model: MotorModel, velocity: float) -> None:
    duty = model.duty(velocity)
    assert abs(duty) <= model.max_duty
    assert not velocity or math.copysign(1, duty) == math.copysign(1, velocity)


def test_wheel_does_not_turn_within_the_dead_band() -> None:
    model = MotorModel(dead_band=0.3, forward_rad_s=10, backward_rad_s=10)
    assert [model.velocity(duty) for duty in (0.0, 0.2, -0.3)] == [0, 0, 0]
    assert model.velocity(0.31) > 0 > model.velocity(-0.31)


def test_full_velocity_differs_by_direction() -> None:
    model = MotorModel(forward_rad_s=16, backward_rad_s=8)
    assert (model.duty(4), model.duty(-4)) == (0.25, -0.5)
    assert (model.reach(1), model.reach(-1)) == (16, 8)


@pytest.mark.parametrize("wrong", [{"dead_band": 1.0}, {"dead_band": -0.1}, {"max_duty": 1.2}, {"forward_rad_s": 0}])
def test_impossible_model_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValidationError):
        MotorModel(**{"forward_rad_s": 10, "backward_rad_s": 10, **wrong})
