"""The corrections of a robot's file that follow from the measured motors."""

from __future__ import annotations

import math
from collections.abc import Iterator

from robotcore.calibration.calibrated_robot import CalibratedRobot
from robotcore.calibration.corrections import Correction
from robotcore.calibration.least_squares import Estimate
from robotcore.calibration.motors.measurement import MotorResult
from robotcore.hardware.motor_model import MotorModel
from robotcore.kinds.motor import MotorDescription

LEAST_DEAD_BAND = 0.001
"""The least difference of a dead band that counts, as a share of the full duty."""

LEAST_LAG_S = 0.003
"""The least difference of a lag that counts, in seconds."""

LEAST_TRIM = 0.005
"""The least difference of a trim that counts. A trim is a factor without a unit."""

REMAINING = {"dead_band_rad_s": 0.0, "forward_gain": 1.0, "backward_gain": 1.0}
"""The keys of a motor's description that describe an error behind a model, and their values without the error.

The dead band is in rad/s. The gains are factors without a unit.
"""


def list_motor_corrections(result: MotorResult, robot: CalibratedRobot) -> list[Correction]:
    """Return the values of a motor in the robot's file, with the measured ones.

    They are shares of the full duty, rad/s and seconds, as the suffixes of their keys say.
    """
    description = next(each for each in robot.description.all_of(MotorDescription) if each.name == result.motor)
    return [*_correct_settings(result, robot, description), *_correct_lag(result, description)]


def _correct_lag(result: MotorResult, description: MotorDescription) -> Iterator[Correction]:
    if result.response:
        place = ("devices", result.motor)
        yield Correction(place, "lag_s", description.lag_s, result.response.lag, LEAST_LAG_S)


def _correct_settings(
    result: MotorResult, robot: CalibratedRobot, description: MotorDescription
) -> Iterator[Correction]:
    section, curve, name = robot.section, result.curve, result.motor
    if section is None:
        return
    if (model := robot.models.get(name)) is None:
        assert robot.description.drive
        # Only with its own encoder, a wheel of another size does not look like a motor of another velocity.
        can_correct_trim = result.instrument in robot.description.drive.encoders or not robot.description.drive.encoders
        if can_correct_trim and (trim := robot.trims.get(name)) is not None:
            yield _correct_trim(result, robot.full_rad_s, (section, name), trim)
        return
    place = (section, name, "model")
    dead_band = Correction(place, "dead_band", model.dead_band, curve.dead_band, LEAST_DEAD_BAND)
    forward = Correction(place, "forward_rad_s", model.forward_rad_s, curve.forward)
    backward = Correction(place, "backward_rad_s", model.backward_rad_s, curve.backward)
    yield from (dead_band, forward, backward)
    corrected = MotorModel(
        **{each.key: each.new if each.is_needed else each.old for each in (dead_band, forward, backward)},
        max_duty=model.max_duty,
    )
    if (reach := min(map(corrected.reach, (1, -1)))) < description.max_velocity_rad_s:
        fastest = Estimate(_round_down(reach), 0.0)
        old = description.max_velocity_rad_s
        yield Correction(("devices", name), "max_velocity_rad_s", old, fastest, is_exact=True)
    for key, ideal in REMAINING.items():
        if (error := getattr(description, key)) != ideal:
            yield Correction(("devices", name), key, error, Estimate(ideal, 0.0), is_exact=True)


def _correct_trim(result: MotorResult, full_rad_s: float, place: tuple[str, ...], trim: float) -> Correction:
    """Return the correction of the factor on each command of a motor that takes velocities.

    full_rad_s: the velocity of the full command, in rad/s.
    trim: the factor in the robot's file.
    """
    # The velocities were measured with the present trim.
    forward, backward = result.curve.forward, result.curve.backward
    gain = (forward.value + backward.value) / 2 / full_rad_s
    deviation = math.hypot(forward.deviation, backward.deviation) / 2 / full_rad_s
    return Correction(place, "trim", trim, Estimate(trim / gain, trim * deviation / gain**2), LEAST_TRIM)


def _round_down(value: float) -> float:
    """Return a positive value, rounded down to three digits.

    >>> _round_down(11.987)
    11.9
    """
    scale = 10.0 ** (2 - math.floor(math.log10(value)))
    return math.floor(value * scale) / scale
