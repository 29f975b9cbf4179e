"""The plans of commands by which the motors of a drive are measured."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from robotcore.calibration.excitation import SIDES, ExcitationStep, Side

CHECK_COMMAND = 0.6
"""The share of the full command at which the wheels are checked one after the other."""

CHECK_S, REST_S = 0.6, 0.3
"""The durations of such a check, and of the rest between two steps, in seconds."""

STEP_S = 0.8
"""The duration of a step at one duty, in seconds."""

LEVELS = tuple(1 - 0.08 * number for number in range(12))
"""The commands of a plan as shares of the greatest one."""

IMU_LEVELS = LEVELS[::2]
"""The commands of a plan in which one wheel drives at a time."""

IMU_REST_S = 2.0
"""The rest before and after the steps of a side, in which the drift of an IMU is measured, in seconds."""


def list_levels(max_command: float, shares: Sequence[float] = LEVELS) -> list[float]:
    """Return commands up to the greatest one, in whole percent, which lgpio can send exactly.

    >>> list_levels(0.9, (1.0, 0.5))
    [0.9, 0.45]
    """
    return [math.floor(100 * max_command * share + 1e-9) / 100 for share in shares]


def plan_wheel_check(max_command: float, *, turns_on_spot: bool) -> list[ExcitationStep]:
    """Return the plan that checks that the encoders count. `check_wheels` reads its log.

    turns_on_spot: whether each side turns alone. Otherwise both turn together, forward and then backward.
    """
    check, rest = min(CHECK_COMMAND, max_command), ExcitationStep(REST_S)
    if turns_on_spot:
        return [rest, ExcitationStep(CHECK_S, left=check), rest, ExcitationStep(CHECK_S, right=check), rest]
    return [rest, ExcitationStep(CHECK_S, check, check), rest, ExcitationStep(CHECK_S, -check, -check), rest]


def plan_for_encoders(max_command: float, *, turns_on_spot: bool) -> list[ExcitationStep]:
    """Return the plan in which all wheels turn at each level, forward and backward.

    turns_on_spot: whether the sides turn in opposite directions, so that the robot stays where it is.
    """
    steps, opposite = [ExcitationStep(REST_S)], -1 if turns_on_spot else 1
    for level in list_levels(max_command):
        for command in (level, -level):
            steps += [ExcitationStep(STEP_S, command, opposite * command), ExcitationStep(REST_S)]
    return steps


def plan_for_imu(max_command: float) -> list[ExcitationStep]:
    """Return the plan in which one side drives at a time, and the robot turns about the other side."""
    rest = ExcitationStep(IMU_REST_S)
    return [rest, *_pivot("left", max_command), rest, *_pivot("right", max_command), rest]


def _pivot(side: Side, max_command: float) -> Iterator[ExcitationStep]:
    assert side in SIDES
    for level in list_levels(max_command, IMU_LEVELS):
        for command in (level, -level):
            yield ExcitationStep(STEP_S, **{side: command})
            yield ExcitationStep(REST_S)
