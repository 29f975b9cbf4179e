"""Drives a robot along a path."""

from __future__ import annotations

import math

from robotcore.autonomy.manoeuvres.motion import STOPPED, Motion
from robotcore.autonomy.manoeuvres.path import Path, Place
from robotcore.autonomy.manoeuvres.speed_profile import SpeedProfile
from robotcore.autonomy.routines import Routine
from robotcore.geometry import Twist, wrap_angle

TURN_GAIN = 4.0
"""The turn rate that corrects the heading, in rad/s for each radian of its error."""

STEERING_GAIN = 5.0
"""The change of the curvature of a robot that steers, in 1/m for each radian. A slow one does not jerk its wheels."""

DRIFT_GAIN = 25.0
"""The change of the curvature that compensates wheels of unequal speed, in 1/m for each metre and radian."""

LOOKAHEAD_S, MIN_LOOKAHEAD_M = 0.5, 0.1
"""The look-ahead in seconds, and its least distance in metres: the robot steers to the point so far ahead."""

STEERING_LOOKAHEAD_M = 0.6
"""The least look-ahead of a robot that steers, in metres. It fits `STEERING_GAIN`, so that the robot does not swing."""

PREVIEW_S = 0.1
"""The wheels follow a new curvature after about this time, in seconds."""

TOLERANCE_M, TOLERANCE_RAD = 0.0005, 0.002
"""The errors at which a correction ends, in metres and in radians."""

STEERING_S, STEERING_M_S = 0.3, 0.001
"""The time for the front wheels to turn before the robot drives, in seconds, and its speed meanwhile, in m/s."""

STANDING_FACTOR = 2.0
"""The tolerance for a robot that stands at the end, divided by that for a moving one. So noise does not move it."""

NEAR_M = 0.01
"""The robot is nearly at the end of a path at this distance, in metres."""


def follow(motion: Motion, path: Path, profile: SpeedProfile, way_after: float = 0.0) -> Routine[None]:
    """Drive along a path until the robot stands at its end.

    way_after: the length of the paths that come afterwards, in metres, for a BlockedError.
    """
    follower, direction = PathFollower(motion, path, profile, way_after), math.copysign(1.0, path.length)
    yield from _steer_before(motion, path, direction)
    while not (follower.is_at_end and motion.is_settled):
        yield from motion.send(follower.steer(), direction)


def _steer_before(motion: Motion, path: Path, direction: float) -> Routine[None]:
    """Let a robot that steers turn its front wheels before it drives. Otherwise the rear wheels would slip."""
    curvature = path.pieces[0].curvature
    for _ in range(0 if motion.can_turn_on_spot else math.ceil(STEERING_S / motion.period)):
        yield from motion.send(Twist(direction * STEERING_M_S, direction * STEERING_M_S * curvature), direction)


class PathFollower:
    """Computes the command for each tick along a path."""

    def __init__(self, motion: Motion, path: Path, profile: SpeedProfile, way_after: float) -> None:
        self._motion, self._path, self._profile, self._way_after = motion, path, profile, way_after
        self._turn_profile = profile.divide(motion.half_track)
        self._progress = self._drift = 0.0
        self.is_at_end = False
        """Whether the robot was at the end of the path in the last tick."""

    def steer(self) -> Twist:
        """Return the command for the next tick."""
        motion = self._motion
        place = self._path.locate(motion.pose, self._progress, PREVIEW_S * motion.sent.linear)
        self._progress = place.progress
        remaining = self._path.length - place.progress
        motion.remaining = {"remaining_m": abs(remaining) + self._way_after}
        remaining -= motion.coasting.linear
        motion.update_correction(remaining, NEAR_M)
        last_step = abs(motion.sent.linear) * motion.period
        if motion.is_correction_over or max(abs(remaining), last_step) < TOLERANCE_M * self._tolerance_factor:
            return self._correct_heading()
        self.is_at_end = False
        return self._steer_to(place, remaining)

    def _correct_heading(self) -> Twist:
        motion = self._motion
        error = wrap_angle(motion.pose.heading + motion.coasting.angular - self._path.end.heading)
        is_aligned = not motion.can_turn_on_spot or abs(error) < TOLERANCE_RAD * self._tolerance_factor
        self.is_at_end = motion.is_correction_over or is_aligned
        return STOPPED if self.is_at_end else Twist(0.0, self._turn_profile.compute_speed(-error, 0.0, motion.period))

    @property
    def _tolerance_factor(self) -> float:
        return STANDING_FACTOR if self.is_at_end else 1.0

    def _steer_to(self, place: Place, remaining: float) -> Twist:
        motion, coasting = self._motion, self._motion.coasting
        linear = self._profile.compute_speed(remaining, motion.sent.linear, motion.period)
        lookahead = max(MIN_LOOKAHEAD_M if motion.can_turn_on_spot else STEERING_LOOKAHEAD_M, LOOKAHEAD_S * abs(linear))
        # Near the end, the heading is more important than the distance from the path.
        share = min(1.0, abs(remaining) / lookahead)
        aim = -math.copysign(share, self._path.length) * math.atan2(place.cross_track, lookahead)
        error = aim - place.heading_error - coasting.angular + place.curvature * coasting.linear
        self._drift += DRIFT_GAIN * error * linear * motion.period
        gain = TURN_GAIN if motion.can_turn_on_spot else min(TURN_GAIN, STEERING_GAIN * abs(linear))
        return Twist(linear, (place.curvature + self._drift) * linear + gain * error)
