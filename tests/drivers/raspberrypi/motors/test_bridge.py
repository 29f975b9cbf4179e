from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.raspberrypi.motors.bridge import whole_percent


@pytest.mark.parametrize("percent", range(-100, 101))
def test_lgpio_sends_the_whole_percent_that_was_meant(percent: int) -> None:
    duty = whole_percent(percent / 100)
    assert int(duty * 100) == percent
    assert duty == pytest.approx(percent / 100)
    assert abs(duty) <= 1


@given(st.floats(-1, 1))
def test_a_duty_is_rounded_to_the_nearest_percent(duty: float) -> None:
    assert abs(whole_percent(duty) - duty) <= 0.005 + 1e-12
