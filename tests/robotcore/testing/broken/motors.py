from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from robotcore.hal.devices import Motor, invalid_velocity
from robotcore.hal.robot import Robot
from tests.robotcore.testing.harness import broken, swap_in

Apply = Callable[[float], None]


def applying(change: Callable[[Apply], Apply]) -> Callable[[Robot], None]:
    def damage(robot: Robot) -> None:
        for motor in robot.motors.values():
            swap_in(motor, "_apply", change(motor._apply))

    return damage


def commanded(change: Callable[[Motor, float], float]) -> Callable[[Robot], None]:
    """Replace set_velocity of every motor."""

    def damage(robot: Robot) -> None:
        for motor in robot.motors.values():
            swap_in(motor, "set_velocity", _bound(change, motor))

    return damage


def _bound(change: Callable[[Motor, float], float], motor: Motor) -> Callable[[float], float]:
    def set_velocity(rad_s: float) -> float:
        motor._require_open()
        return change(motor, rad_s)

    return set_velocity


def swapped(robot: Robot) -> None:
    motors = list(robot.motors.values())
    if len(motors) == 2:
        left, right = motors
        left_apply, right_apply = left._apply, right._apply
        swap_in(left, "_apply", right_apply)
        swap_in(right, "_apply", left_apply)


def ignoring_zero(apply: Apply) -> Apply:
    return lambda rad_s: apply(rad_s) if rad_s else None


def clamped(motor: Motor, rad_s: float) -> float:
    return math.copysign(min(abs(rad_s), motor.max_velocity), rad_s)


def sent(motor: Motor, rad_s: float) -> float:
    """Clamp the velocity, send it and return it."""
    return Motor.set_velocity(motor, rad_s)


def returns_the_limit(motor: Motor, rad_s: float) -> float:
    sent(motor, rad_s)
    return math.copysign(motor.max_velocity, rad_s)


def returns_what_was_asked(motor: Motor, rad_s: float) -> float:
    sent(motor, rad_s)
    return rad_s


def sends_unclamped(motor: Motor, rad_s: float) -> float:
    if not math.isfinite(rad_s):
        return sent(motor, rad_s)
    motor._apply(rad_s)
    return clamped(motor, rad_s)


def swallows_nan(motor: Motor, rad_s: float) -> float:
    return sent(motor, rad_s if math.isfinite(rad_s) else 0.0)


def refuses_without_stopping(motor: Motor, rad_s: float) -> float:
    if not math.isfinite(rad_s):
        raise invalid_velocity(motor.name, rad_s)
    return sent(motor, rad_s)


def too_fast(robot: Robot) -> None:
    for motor in robot.motors.values():
        motor.max_velocity = 100.0


def scaled(factor: float) -> Callable[[Apply], Apply]:
    def change(apply: Apply) -> Apply:
        return lambda rad_s: apply(factor * rad_s)

    return change


BROKEN: tuple[Any, ...] = (
    broken(
        "the motors are mounted the wrong way round",
        "positive_velocity_drives_forward left_motor_faster_turns_right encoders_count_forward_as_positive "
        "bump_into_a_wall_is_one_contact",
        applying(scaled(-1.0)),
    ),
    broken(
        "left and right motor are swapped",
        "left_motor_faster_turns_right each_encoder_counts_its_own_wheel",
        swapped,
    ),
    broken(
        "velocities are not in rad/s",
        "velocity_is_in_radians_per_second angles_are_in_radians",
        applying(scaled(0.5)),
    ),
    broken("zero is not sent", "stop_brings_the_wheels_to_rest", applying(ignoring_zero)),
    broken(
        "set_velocity returns the limit",
        "velocity_within_the_limits_is_returned_as_it_is",
        commanded(returns_the_limit),
    ),
    broken(
        "set_velocity returns the requested velocity",
        "velocity_beyond_the_limit_is_clamped_and_returned",
        commanded(returns_what_was_asked),
    ),
    broken(
        "set_velocity sends unclamped",
        "velocity_beyond_the_limit_is_clamped_and_returned",
        commanded(sends_unclamped),
    ),
    broken("the limit is not the described one", "limit_is_the_one_described", too_fast),
    broken("NaN is taken for zero", "velocity_that_is_no_number_is_refused", commanded(swallows_nan)),
    broken("NaN is refused in full motion", "refused_velocity_stops_the_motor", commanded(refuses_without_stopping)),
)
