from __future__ import annotations

import math
from dataclasses import replace

from robotcore.hal.devices import Encoder
from robotcore.hal.robot import Robot
from tests.robotcore.testing.broken.sensing import Damage, saying
from tests.robotcore.testing.harness import broken, swap_in


def angle_scaled(factor: float, offset: float = 0.0) -> Damage:
    return saying(Encoder, lambda sample: replace(sample, angle=factor * sample.angle + offset))


def swapped(robot: Robot) -> None:
    encoders = [device for device in robot.devices.values() if isinstance(device, Encoder)]
    if len(encoders) == 2:
        left, right = encoders
        left_newest, right_newest = left._newest, right._newest
        swap_in(left, "_newest", right_newest)
        swap_in(right, "_newest", left_newest)


BROKEN = (
    broken("angles do not count from the opening", "encoders_begin_at_zero", angle_scaled(1.0, 7.0)),
    broken(
        "encoders count backwards",
        "encoders_count_forward_as_positive pose_moves_as_the_wheels_roll",
        angle_scaled(-1.0),
    ),
    broken(
        "angles are in degrees",
        "angles_are_in_radians pose_moves_as_the_wheels_roll",
        angle_scaled(math.degrees(1.0)),
    ),
    broken(
        "left and right encoder are swapped",
        "each_encoder_counts_its_own_wheel pose_moves_as_the_wheels_roll",
        swapped,
    ),
)
