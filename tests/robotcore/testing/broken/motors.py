from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from robotcore.errors import DeviceClosedError
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import Motor, invalid_velocity
from tests.robotcore.testing.harness import broken, replace_attribute

Apply = Callable[[float], None]


def change_apply(change: Callable[[Apply], Apply]) -> Callable[[Robot], None]:
    def damage(robot: Robot) -> None:
        for motor in robot.motors.values():
            replace_attribute(motor, "_apply", change(motor._apply))

    return damage


def change_set_velocity(change: Callable[[Motor, float], float]) -> Callable[[Robot], None]:
    """Replace set_velocity of every motor."""

    def damage(robot: Robot) -> None:
        for motor in robot.motors.values():
            replace_attribute(motor, "set_velocity", _build_set_velocity(change, motor))

    return damage


def _build_set_velocity(change: Callable[[Motor, float], float], motor: Motor) -> Callable[[float], float]:
    def set_velocity(rad_s: float) -> float:
        if motor._is_closed:
            raise DeviceClosedError(motor.name)
        return change(motor, rad_s)

    return set_velocity


def swap_motors(robot: Robot) -> None:
    motors = list(robot.motors.values())
    if len(motors) == 2:
        left, right = motors
        left_apply, right_apply = left._apply, right._apply
        replace_attribute(left, "_apply", right_apply)
        replace_attribute(right, "_apply", left_apply)


def ignore_zero(apply: Apply) -> Apply:
    return lambda rad_s: apply(rad_s) if rad_s else None


def clamp(motor: Motor, rad_s: float) -> float:
    return math.copysign(min(abs(rad_s), motor.max_velocity), rad_s)


def send_clamped(motor: Motor, rad_s: float) -> float:
    """Clamp the velocity, send it and return it."""
    return Motor.set_velocity(motor, rad_s)


def return_the_limit(motor: Motor, rad_s: float) -> float:
    send_clamped(motor, rad_s)
    return math.copysign(motor.max_velocity, rad_s)


def return_the_request(motor: Motor, rad_s: float) -> float:
    send_clamped(motor, rad_s)
    return rad_s


def send_unclamped(motor: Motor, rad_s: float) -> float:
    if not math.isfinite(rad_s):
        return send_clamped(motor, rad_s)
    motor._apply(rad_s)
    return clamp(motor, rad_s)


def replace_nan_by_zero(motor: Motor, rad_s: float) -> float:
    return send_clamped(motor, rad_s if math.isfinite(rad_s) else 0.0)


def keep_driving_at_nan(motor: Motor, rad_s: float) -> float:
    if not math.isfinite(rad_s):
        raise invalid_velocity(motor.name, rad_s)
    return send_clamped(motor, rad_s)


def raise_the_limit(robot: Robot) -> None:
    for motor in robot.motors.values():
        motor.max_velocity = 100.0


def change_velocity(change: Callable[[float], float]) -> Callable[[Apply], Apply]:
    return lambda apply: lambda rad_s: apply(change(rad_s))


def scale(factor: float) -> Callable[[Apply], Apply]:
    return change_velocity(lambda rad_s: factor * rad_s)


BROKEN: tuple[Any, ...] = (
    broken(
        "the motors are mounted the wrong way round",
        "positive_velocity_drives_forward left_motor_faster_turns_right encoders_count_forward_as_positive "
        "wheels_turn_at_the_commanded_velocity bump_into_a_wall_is_one_contact",
        change_apply(scale(-1.0)),
    ),
    broken(
        "the motors cannot turn backward",
        "wheels_turn_at_the_commanded_velocity encoders_count_forward_as_positive",
        change_apply(change_velocity(abs)),
    ),
    broken(
        "the velocities are whole numbers",
        "wheels_turn_at_the_commanded_velocity",
        change_apply(change_velocity(int)),
    ),
    broken(
        "slow commands do not turn the wheels",
        "wheels_turn_at_the_commanded_velocity",
        change_apply(change_velocity(lambda rad_s: rad_s if abs(rad_s) > 1.5 else 0.0)),
    ),
    broken(
        "the wheels do not reach the limit",
        "wheels_turn_at_the_commanded_velocity",
        change_apply(change_velocity(lambda rad_s: min(rad_s, 5.0))),
    ),
    broken(
        "left and right motor are swapped",
        "left_motor_faster_turns_right each_encoder_counts_its_own_wheel",
        swap_motors,
    ),
    broken(
        "velocities are not in rad/s",
        "wheels_turn_at_the_commanded_velocity angles_are_in_radians",
        change_apply(scale(0.5)),
    ),
    broken("zero is not sent", "stop_brings_the_wheels_to_rest", change_apply(ignore_zero)),
    broken(
        "set_velocity returns the limit",
        "velocity_within_the_limits_is_returned_unchanged",
        change_set_velocity(return_the_limit),
    ),
    broken(
        "set_velocity returns the requested velocity",
        "velocity_beyond_the_limit_is_clamped_and_returned",
        change_set_velocity(return_the_request),
    ),
    broken(
        "set_velocity sends unclamped",
        "velocity_beyond_the_limit_is_clamped_and_returned",
        change_set_velocity(send_unclamped),
    ),
    broken("the limit is not the described one", "limit_does_not_exceed_the_description", raise_the_limit),
    broken("NaN is sent as zero", "velocity_that_is_not_finite_is_refused", change_set_velocity(replace_nan_by_zero)),
    broken(
        "NaN is refused without a stop", "refused_velocity_stops_the_motor", change_set_velocity(keep_driving_at_nan)
    ),
)
