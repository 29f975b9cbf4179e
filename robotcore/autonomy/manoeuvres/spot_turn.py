"""Turns a robot on the spot."""

from __future__ import annotations

from robotcore.autonomy.manoeuvres.motion import STOPPED, Motion
from robotcore.autonomy.manoeuvres.path_following import STANDING_FACTOR, TOLERANCE_RAD
from robotcore.autonomy.manoeuvres.speed_profile import SpeedProfile
from robotcore.autonomy.routines import Routine
from robotcore.geometry import Pose, Twist

NEAR_RAD = 0.05
"""The robot is nearly at the end of a turn at this angle, in radians."""

HOLD_GAIN = 2.0
"""The speed back to the place at which a turn began, in m/s for each metre of distance."""

HOLD_M = 0.001
"""The greatest distance from this place that is not corrected, in metres."""


def turn_on_spot(motion: Motion, heading: float, profile: SpeedProfile) -> Routine[None]:
    """Turn on the spot until the robot stands at a heading.

    heading: the heading at the end, in radians. It counts whole turns.
    """
    place, is_at_end = motion.pose, False
    while not (is_at_end and motion.is_settled):
        remaining = heading - motion.pose.heading
        motion.remaining = {"remaining_rad": abs(remaining)}
        remaining -= motion.coasting.angular
        motion.update_correction(remaining, NEAR_RAD)
        last_step = abs(motion.sent.angular) * motion.period
        tolerance = TOLERANCE_RAD * (STANDING_FACTOR if is_at_end else 1.0)
        is_at_end = motion.is_correction_over or max(abs(remaining), last_step) < tolerance
        yield from motion.send(STOPPED if is_at_end else _turn_to(motion, place, remaining, profile))


def _turn_to(motion: Motion, place: Pose, remaining: float, profile: SpeedProfile) -> Twist:
    back, _ = motion.pose.to_local(place.x, place.y)
    angular = profile.compute_speed(remaining, motion.sent.angular, motion.period)
    return Twist(HOLD_GAIN * back if abs(back) > HOLD_M else 0.0, angular)
