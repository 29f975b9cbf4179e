from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore import RunRequest, run
from robotcore.calibration.excitation import CommandStep, Excitation, ExcitationLog, ExcitationStep, TruePoseObserver
from robotcore.geometry import Wheels

STEPS = (ExcitationStep(0.2), ExcitationStep(0.5, 0.5, 0.5), ExcitationStep(0.3, 0.5, -0.5), ExcitationStep(0.2))


def test_an_excitation_sends_its_plan_and_stands_at_the_end() -> None:
    excitation, observer = Excitation(STEPS, full_rad_s=8.0), TruePoseObserver()
    result = run(RunRequest(excitation, "kinematic", world="open", rate_hz=50), [observer])
    assert result.error is None
    log = excitation.log
    assert [(step.command, round(step.end - step.start, 6)) for step in log.list_steps("left")] == [
        (0.0, 0.2), (0.5, 0.8), (0.0, 0.2),
    ]  # fmt: skip
    assert [step.command for step in log.list_steps("right")] == [0.0, 0.5, -0.5, 0.0]
    assert log.measure_turns("left_encoder") == pytest.approx([0.0, 1.8, 1.2, 0.2], abs=0.15)
    times, turned = log.integrate_sent("left")
    assert (times[-1], turned[-1]) == pytest.approx((1.2, 3.2), abs=0.3)  # the file limits the acceleration
    assert observer.displacement
    assert observer.displacement[0] > 0.05
    assert observer.turned < -0.2


def test_a_sample_that_is_read_twice_is_logged_once() -> None:
    log = ExcitationLog()
    for time in (0.0, 0.1, 0.1, 0.2):
        log.add("nose", time, time)
    times, values = log.read_series("nose")
    assert times.tolist() == values.tolist() == [0.0, 0.1, 0.2]


def test_sent_velocities_are_integrated_until_the_end() -> None:
    log = ExcitationLog()
    log.begin(0.0, ExcitationStep(0.3))
    for number, velocity in enumerate((0.0, 2.0, 4.0)):
        log.add_sent(number / 10, Wheels(velocity, -velocity))
    log.finish(0.3)
    assert log.integrate_sent("right")[1].tolist() == pytest.approx([0.0, 0.0, -0.2, -0.6])
    assert log.list_steps("left") == [CommandStep(0.0, 0.3, 0.0)]


def test_sent_velocities_turn_a_wheel_with_its_lag() -> None:
    log = ExcitationLog()
    log.begin(0.0, ExcitationStep(3.0))
    for number in range(300):
        log.add_sent(number / 100, Wheels(4.0, 4.0) if number < 100 else Wheels(0.0, 0.0))
    log.finish(3.0)
    times, turned = log.integrate_sent("left", lag_s=0.2)
    assert np.interp(1.0, times, turned) == pytest.approx(4.0 * (1.0 - 0.2 * (1 - math.exp(-5))))
    assert turned[-1] == pytest.approx(4.0, rel=1e-4)
