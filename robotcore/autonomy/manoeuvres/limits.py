"""Checks the arguments of manoeuvres, and derives speeds and accelerations from the limits of a drive."""

from __future__ import annotations

import math

from robotcore.autonomy.manoeuvres.speed_profile import SLOWEST_M_S, SpeedProfile
from robotcore.errors import UsageError
from robotcore.geometry import to_number
from robotcore.hal.drive import DifferentialDrive

MAX_M = 100.0
"""The greatest distance, radius and coordinate of a manoeuvre, in metres. A greater value is probably not in metres."""

MAX_RAD = 20.0
"""The greatest angle of a manoeuvre, in radians: 3 turns. A greater value is probably in degrees."""

SPEED_SHARE = 0.5
"""The speed of the outer wheel along a path, divided by its greatest one."""

TURN_SHARE = 0.3
"""The turn rate on the spot, divided by the greatest one."""

TURN_ACCELERATION_SHARE = 0.5
"""The acceleration of the wheels in a turn on the spot, divided by that along a path. The angles are small."""

ACCELERATION_SHARE = 0.8
"""The acceleration, divided by the greatest one. The rest is for corrections."""


def require_number(
    manoeuvre: str, name: str, value: float, unit: str, limit: float, *, least: float | None = None
) -> float:
    """Return an argument of a manoeuvre as a float.

    manoeuvre: the name of the manoeuvre.
    name: the name of the argument.
    unit: the unit, for messages.
    limit: the greatest allowed value.
    least: the least allowed value; by default -limit.

    Raises UsageError if the argument is no number between these.
    """
    number, least = to_number(value), -limit if least is None else least
    if not least <= number <= limit:
        raise _build_error(manoeuvre, name, value, f"a number of {unit} from {least:.4g} to {limit:.4g}")
    return number


def require_angle(manoeuvre: str, name: str, value: float, limit: float = MAX_RAD) -> float:
    """Return an angle in radians as a float. Raises UsageError if it is no number from -limit to limit."""
    number = to_number(value)
    if limit < abs(number) < math.inf:
        allowed = f"an angle in radians, at most {limit:.4g}: {number:g} rad is {abs(number) / math.tau:.0f} turns"
        raise _build_error(manoeuvre, name, value, f"{allowed}. For degrees, write math.radians({number:g})")
    return require_number(manoeuvre, name, value, "radians", limit)


def require_positive(manoeuvre: str, name: str, value: float, unit: str, limit: float) -> float:
    """Return an argument of a manoeuvre as a float. Raises UsageError if it is no number above 0, at most ``limit``."""
    number = to_number(value)
    if not 0 < number <= limit:
        raise _build_error(manoeuvre, name, value, f"a number of {unit} above 0 and at most {limit:.4g}")
    return number


def require_radius(manoeuvre: str, drive: DifferentialDrive, radius: float) -> float:
    """Return a radius in metres. Raises UsageError if the robot cannot turn so sharply."""
    if radius < drive.min_turn_radius:
        raise UsageError(
            f"{manoeuvre} has a radius of {radius:g} m, but the robot steers, and its sharpest turn has a radius of "
            f"{drive.min_turn_radius:.3f} m. Give a greater radius",
            kind="turn-too-sharp",
            radius_m=radius,
            min_turn_radius_m=drive.min_turn_radius,
        )
    return radius


def _build_error(manoeuvre: str, name: str, value: object, allowed: str) -> UsageError:
    return UsageError(
        f"{name} of {manoeuvre} is {value!r:.50}. Give {allowed}",
        kind="manoeuvre-argument",
        manoeuvre=manoeuvre,
        argument=name,
    )


def build_path_profile(
    manoeuvre: str, drive: DifferentialDrive, speed: float | None, curvature: float = 0.0
) -> SpeedProfile:
    """Return the profile of the speed along a path.

    speed: the greatest speed in m/s; None for a moderate one.
    curvature: the greatest curvature of the path, in 1/m.

    Raises UsageError if the speed is not above 0, or if the outer wheel cannot reach it.
    """
    outer = 1 + abs(curvature) * drive.geometry.track / 2
    top = SPEED_SHARE * drive.max_linear / outer
    if speed is not None:
        top = require_positive(manoeuvre, "speed", speed, "m/s", drive.max_linear / outer)
    return SpeedProfile(top, _compute_acceleration(drive) / outer, SLOWEST_M_S / outer)


def build_turn_profile(manoeuvre: str, drive: DifferentialDrive, turn_rate: float | None) -> SpeedProfile:
    """Return the profile of the turn rate on the spot.

    turn_rate: the greatest turn rate in rad/s; None for a moderate one.

    Raises UsageError if the turn rate is not above 0, if the drive cannot reach it, or if the robot cannot turn on the
    spot.
    """
    if drive.min_turn_radius:
        raise UsageError(
            f"{manoeuvre} turns the robot on the spot, but this robot steers, and cannot. Use arc with a radius of at "
            f"least {drive.min_turn_radius:.3f} m",
            kind="cannot-turn-on-spot",
            manoeuvre=manoeuvre,
            min_turn_radius_m=drive.min_turn_radius,
        )
    top = TURN_SHARE * drive.max_angular
    if turn_rate is not None:
        top = require_positive(manoeuvre, "turn_rate", turn_rate, "rad/s", drive.max_angular)
    half_track = drive.geometry.track / 2
    acceleration = TURN_ACCELERATION_SHARE * _compute_acceleration(drive)
    return SpeedProfile(top, acceleration / half_track, SLOWEST_M_S / half_track)


def _compute_acceleration(drive: DifferentialDrive) -> float:
    return min(drive.deceleration, ACCELERATION_SHARE * drive.max_acceleration)
