"""Measures the motors of a drive: by the encoders, by an IMU, or by a tape measure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum

import numpy as np

from robotcore.calibration.excitation import SIDES, ExcitationLog, Side
from robotcore.calibration.excitation_runs import ExcitationRunner
from robotcore.calibration.least_squares import Array
from robotcore.calibration.motors.plans import (
    IMU_REST_S,
    list_levels,
    plan_for_encoders,
    plan_for_imu,
    plan_wheel_check,
)
from robotcore.calibration.motors.response import Response, fit_response, shorten_rests
from robotcore.calibration.motors.tape_fit import PresentMotor, TapeDrive, fit_tape
from robotcore.calibration.motors.velocity_curve import CurvePoint, VelocityCurve, fit_velocity_curve
from robotcore.calibration.motors.wheel_check import check_wheels
from robotcore.description import AckermannDrive, Drive
from robotcore.errors import CalibrationError, UsageError
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription

TAPE_LEVELS, TAPE_WAYS = (1.0, 0.75, 0.5), (1.0, 0.5, 1.0)
"""The commands of the drives along a tape measure, as shares of the greatest one, and the lengths of these drives."""

MIN_DRIVE_S, MAX_DRIVE_S = 1.0, 20.0
"""The limits of the duration of a drive along a tape measure, in seconds."""

SETTLE_S = 1.0
"""The rest after such a drive, in which the robot coasts, in seconds."""


class Method(str, Enum):
    """The measuring instrument of a calibration."""

    ENCODER = "encoder"
    IMU = "imu"
    TAPE = "tape"


@dataclass(frozen=True)
class MotorResult:
    """The measured properties of a motor."""

    motor: str
    instrument: str
    """The name of the encoder or of the IMU that measured it, or ``tape measure``."""
    curve: VelocityCurve
    response: Response | None
    """The response to steps of the command. None if only distances were measured."""


def choose_method(runner: ExcitationRunner) -> Method:
    """Return the best method that the devices of the robot allow."""
    robot = runner.robot.description
    assert robot.drive
    if robot.drive.encoders:
        return Method.ENCODER
    has_imu = bool(robot.all_of("imu")) and not isinstance(robot.drive, AckermannDrive)
    return Method.IMU if has_imu else Method.TAPE


def measure_motors(runner: ExcitationRunner, method: Method, distance_m: float = 1.0) -> list[MotorResult]:
    """Drive the robot, and return the properties of each motor of its drive.

    distance_m: the length of a drive along a tape measure, in metres.

    Raises UsageError for a method that the robot does not allow, and CalibrationError if a motor cannot be measured.
    """
    measure = {Method.ENCODER: _measure_by_encoders, Method.IMU: _measure_by_imu}.get(method)
    results = measure(runner) if measure else _measure_by_tape(runner, distance_m)
    for each in results:
        if not each.curve.is_fitting:
            raise CalibrationError(
                f"{each.motor}: its velocities are not those of a motor with a dead band (R² is "
                f"{each.curve.r_squared:.2f}). Check that nothing blocks the robot, that its wheels do not slip, and "
                "that the battery is charged",
                kind="poor-fit",
                device=each.motor,
                r_squared=each.curve.r_squared,
            )
    return results


def _measure_by_encoders(runner: ExcitationRunner) -> list[MotorResult]:
    robot, drive = runner.robot.description, runner.drive
    encoders = {side: _pair_encoders(drive, side) for side in SIDES}
    if not all(encoders.values()):
        raise _refuse(Method.ENCODER, "[drive] names no encoders")
    on_spot = not robot.min_turn_radius_m
    resolutions = {each.name: math.tau / each.counts_per_turn for each in robot.all_of(EncoderDescription)}
    # First, because a robot with a reversed motor would drive away in place of turning on the spot.
    check = runner.excite(plan_wheel_check(runner.robot.max_command, turns_on_spot=on_spot))
    check_wheels(check.log, encoders, resolutions, is_alone=on_spot)
    excitation = runner.excite(plan_for_encoders(runner.robot.max_command, turns_on_spot=on_spot))
    found = {}
    for side in SIDES:
        for motor, encoder in encoders[side].items():
            times, angles = _read_angles(excitation.log, drive, encoder)
            with _name_motors([motor]):
                response = fit_response(excitation.log.list_steps(side), times, angles)
                found[motor] = MotorResult(motor, encoder, _fit_curve(response), response)
    return list(found.values())


def _read_angles(log: ExcitationLog, drive: Drive, encoder: str) -> tuple[Array, Array]:
    """Return the times and the angles of an encoder.

    The wheels of a robot that steers roll along one arc. Their mean does not depend on the angle of the servo.
    """
    times, angles = log.read_series(encoder)
    if not isinstance(drive, AckermannDrive):
        return times, angles
    series = (log.read_series(name) for name in drive.encoders)
    return times, np.mean([np.interp(times, *each) for each in series], axis=0)


def _pair_encoders(drive: Drive, side: Side) -> dict[str, str]:
    """Return the encoder that measures each motor of a side. A motor without one gets the last encoder of its side."""
    motors, encoders = (
        (drive.left_motors, drive.left_encoders) if side == "left" else (drive.right_motors, drive.right_encoders)
    )
    if not encoders:
        return {}
    return {motor: encoders[min(number, len(encoders) - 1)] for number, motor in enumerate(motors)}


def _measure_by_imu(runner: ExcitationRunner) -> list[MotorResult]:
    robot, drive = runner.robot.description, runner.drive
    if (imu := robot.first_of("imu")) is None:
        raise _refuse(Method.IMU, "the robot has no IMU")
    if robot.min_turn_radius_m:
        raise _refuse(Method.IMU, "a robot that steers cannot turn about one wheel")
    excitation = runner.excite(plan_for_imu(runner.robot.max_command))
    times, headings = excitation.log.read_series(imu.name)
    if float(np.ptp(headings)) < 1.0:
        raise CalibrationError(
            f"{imu.name} measured a turn of {float(np.ptp(headings)):.2f} rad only. Put the robot on the floor, and "
            "check its motors and its IMU with robotcore test-devices",
            kind="no-motion",
            devices=(imu.name,),
        )
    results = []
    for side in SIDES:
        sign, motors = (-1, drive.left_motors) if side == "left" else (1, drive.right_motors)
        angles = sign * headings * drive.geometry.track / drive.geometry.wheel_radius
        steps = shorten_rests(excitation.log.list_steps(side), IMU_REST_S)
        with _name_motors(motors):
            response = fit_response(steps, times, angles, has_drift=True)
        _require_forward(side, motors, response, imu.name)
        with _name_motors(motors):
            curve = _fit_curve(response)
        results += [MotorResult(motor, imu.name, curve, response) for motor in motors]
    return results


def _require_forward(side: str, motors: Sequence[str], response: Response, imu: str) -> None:
    if sum(np.sign(step.command) * velocity.value for step, velocity in response.velocities) < 0:
        raise CalibrationError(
            f"{imu} measured turns to the {side} while {' and '.join(motors)} drove forward. Check with robotcore "
            "test-devices which wheel turns, and in which direction",
            kind="turns-backward",
            devices=tuple(motors),
        )


def _fit_curve(response: Response) -> VelocityCurve:
    return fit_velocity_curve([CurvePoint(step.command, velocity) for step, velocity in response.velocities])


@contextmanager
def _name_motors(motors: Sequence[str]) -> Iterator[None]:
    """Add the names of motors to a CalibrationError."""
    try:
        yield
    except CalibrationError as error:
        text = f"{' and '.join(motors)}: {error}"
        raise CalibrationError(text, kind=error.kind, device=motors[0], **error.fields) from error


def _measure_by_tape(runner: ExcitationRunner, distance_m: float) -> list[MotorResult]:
    drive, drives = runner.drive, []
    commands = [
        (sign * level, distance_m * share)
        for level, share in zip(list_levels(runner.robot.max_command, TAPE_LEVELS), TAPE_WAYS, strict=True)
        for sign in (1, -1)
    ]
    for number, (command, way_m) in enumerate(commands, start=1):
        speed = abs(_predict_rad_s(runner, command)) * drive.wheel_radius_m
        duration = min(max(way_m / speed if speed else MAX_DRIVE_S, MIN_DRIVE_S), MAX_DRIVE_S)
        duration = round(duration * runner.rate_hz) / runner.rate_hz
        moved, _ = runner.drive_straight(command, duration, SETTLE_S, f"drive {number} of {len(commands)}")
        drives.append(TapeDrive(command, duration, moved))
    sides = [drive.left_motors] if drive.left_motors == drive.right_motors else [drive.left_motors, drive.right_motors]
    curves = fit_tape(drives, drive.geometry, [_read_present(runner, motors[0]) for motors in sides])
    return [
        MotorResult(motor, "tape measure", curve, None)
        for motors, curve in zip(sides, curves, strict=True)
        for motor in motors
    ]


def _read_present(runner: ExcitationRunner, motor: str) -> PresentMotor:
    """Return the values of a motor in the robot's file."""
    robot = runner.robot
    lag_s = next(each.lag_s for each in robot.description.all_of(MotorDescription) if each.name == motor)
    if model := robot.models.get(motor):
        return PresentMotor(model.dead_band, model.forward_rad_s, model.backward_rad_s, lag_s)
    return PresentMotor(0.0, robot.full_rad_s, robot.full_rad_s, lag_s)


def _predict_rad_s(runner: ExcitationRunner, command: float) -> float:
    """Return the velocity at a command by the present model of the first motor, in rad/s."""
    models = runner.robot.models
    return next(iter(models.values())).velocity(command) if models else command * runner.robot.full_rad_s


def _refuse(method: Method, reason: str) -> UsageError:
    others = ", ".join(f"--by {each.value}" for each in Method if each is not method)
    text = f"--by {method.value}: {reason}. Leave --by out, or give one of {others}"
    return UsageError(text, kind="method-not-possible", method=method.value)
