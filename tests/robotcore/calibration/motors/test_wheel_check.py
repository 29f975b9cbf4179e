from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.calibration.excitation import ExcitationLog, ExcitationStep, Side
from robotcore.calibration.motors.plans import plan_wheel_check
from robotcore.calibration.motors.wheel_check import check_wheels
from robotcore.errors import CalibrationError
from tests.texts import Raises

ENCODERS: dict[Side, dict[str, str]] = {
    "left": {"left_motor": "left_encoder"},
    "right": {"right_motor": "right_encoder"},
}
RESOLUTIONS = {"left_encoder": 0.1, "right_encoder": 0.1}
Turn = Callable[[ExcitationStep], float]


def log_checks(left: Turn, right: Turn, *, is_alone: bool = True) -> ExcitationLog:
    """Return the log of the first steps of a plan. ``left`` and ``right`` return the velocity of an encoder."""
    log, time, angles = ExcitationLog(), 0.0, [0.0, 0.0]
    for step in plan_wheel_check(1.0, turns_on_spot=is_alone):
        log.begin(time, step)
        for _ in range(round(step.duration_s / 0.01)):
            for number, (name, turn) in enumerate((("left_encoder", left), ("right_encoder", right))):
                log.add(name, time, angles[number])
                angles[number] += turn(step) * 0.01
            time += 0.01
    log.finish(time)
    return log


def test_wheels_that_turn_as_commanded_pass() -> None:
    check_wheels(log_checks(lambda s: 8 * s.left, lambda s: 8 * s.right), ENCODERS, RESOLUTIONS, is_alone=True)
    together = log_checks(lambda s: 8 * s.left, lambda s: 8 * s.right, is_alone=False)
    check_wheels(together, ENCODERS, RESOLUTIONS, is_alone=False)


@pytest.mark.parametrize(
    "left, right, kind, devices",
    [
        (lambda s: 0.0, lambda s: 8 * s.right, "no-motion", ("left_encoder",)),
        (lambda s: 0.1 * s.left, lambda s: 8 * s.right, "no-motion", ("left_encoder",)),
        (lambda s: 8 * s.left, lambda s: -8 * s.right, "counts-backward", ("right_encoder",)),
        (lambda s: 8 * s.right, lambda s: 8 * s.left, "sides-swapped", ("left_encoder", "right_encoder")),
    ],
)
def test_a_wheel_that_does_not_turn_as_commanded_is_an_error(
    left: Turn, right: Turn, kind: str, devices: tuple[str, ...], raises: Raises
) -> None:
    with raises(CalibrationError, kind, devices=devices):
        check_wheels(log_checks(left, right), ENCODERS, RESOLUTIONS, is_alone=True)
