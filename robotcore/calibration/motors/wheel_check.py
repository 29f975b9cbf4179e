"""Checks that each encoder counts the wheel of its motor, and in the right direction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from robotcore.calibration.excitation import SIDES, ExcitationLog, Side
from robotcore.errors import CalibrationError

MIN_COUNTS = 3
"""The least number of counts of an encoder whose wheel turns."""

MIN_SHARE = 0.3
"""The encoder of the driven side must turn by this share of the angle of the other side at least."""

ADVICE = "Find the fault with robotcore test-devices"


def check_wheels(
    log: ExcitationLog, encoders: Mapping[Side, Mapping[str, str]], resolutions: Mapping[str, float], *, is_alone: bool
) -> None:
    """Raise CalibrationError if an encoder does not count, counts backward, or counts the wheel of the other side.

    log: the log of the plan `plan_wheel_check`.
    encoders: for each side its motors, and the encoder of each.
    resolutions: the angle of a count of each encoder, in radians.
    is_alone: whether each side turned alone. Otherwise both turned together, at first forward and then backward.
    """
    turns = {name: log.measure_turns(name) for side in SIDES for name in encoders[side].values()}
    first = {name: steps[1] + steps[2] for name, steps in turns.items()}
    second = {name: steps[3] + steps[4] for name, steps in turns.items()}
    problems: list[tuple[str, str, str]] = []
    for side in SIDES:
        own = first if side == "left" or not is_alone else second
        other = encoders["right" if side == "left" else "left"].values()
        beside = max((abs(own[name]) for name in other), default=0.0) if is_alone else 0.0
        for motor, encoder in encoders[side].items():
            problems += _find_problem(motor, encoder, own[encoder], beside, resolutions[encoder])
    if problems:
        texts = dict.fromkeys(text for _, _, text in problems)
        raise CalibrationError(
            f"{'. '.join(texts)}. {ADVICE}", kind=problems[0][0], devices=tuple(name for _, name, _ in problems)
        )


def _find_problem(
    motor: str, encoder: str, turned: float, beside: float, resolution: float
) -> Iterator[tuple[str, str, str]]:
    """Yield the kind, the device and the text of a problem.

    turned: the angle of the encoder while its motor was commanded forward, in radians.
    beside: the greatest angle of the encoders of the other side in this time, in radians.
    """
    if abs(turned) < max(MIN_COUNTS * resolution, MIN_SHARE * beside):
        if beside > MIN_COUNTS * resolution:
            text = f"{motor} was commanded to turn, and the encoder of the other side counted, not {encoder}"
            yield "sides-swapped", encoder, text
            return
        text = f"{motor} was commanded to turn forward, and {encoder} counted {_describe(turned)}"
        yield (
            "no-motion",
            encoder,
            f"{text}: the wheel does not turn, something blocks the robot, or the encoder does not count",
        )
    elif turned < 0:
        text = f"{motor} was commanded to turn forward, and {encoder} counted {_describe(turned)}"
        yield "counts-backward", encoder, f"{text}: the motor turns backward, or the encoder counts backward"


def _describe(turned: float) -> str:
    return f"{round(turned / math.tau, 2) + 0.0:g} turns"
