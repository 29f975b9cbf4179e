"""``robotcore calibrate motors``: measure the dead band, the velocities and the lag of the motors of a drive."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.calibrate.distances import distance_option
from robotcore.cli.calibrate.excitation_runner import build_runner
from robotcore.cli.output import write_line, write_table
from robotcore.cli.robot_session import OPEN, MeasuringCommand, RobotSession, robot_session_options

if TYPE_CHECKING:
    from robotcore.calibration.calibrated_robot import CalibratedRobot
    from robotcore.calibration.corrections import Correction
    from robotcore.calibration.least_squares import Estimate
    from robotcore.calibration.motors.measurement import Method, MotorResult

FLOOR = (
    "Put the robot on a stand, so that its wheels turn freely, or on the floor with 1 m of free space around it. It "
    "turns on the spot at up to full speed. Take the charged battery with which it drives"
)
PIVOT = (
    "Put the robot on the floor with 1 m of free space around it. It turns about one wheel, then about the other, at "
    "up to full speed. Take the charged battery with which it drives"
)


@click.command("motors", cls=MeasuringCommand, short_help="Measure the motors: dead band, velocities, lag.")
@robot_session_options(OPEN)
@click.option(
    "--by",
    "method",
    type=click.Choice(["encoder", "imu", "tape"]),
    help="The measuring instrument. Default: the encoders, else the IMU, else a tape measure.",
)
@distance_option(most_m=10, default_m=1.0, text="The length of a drive along a tape measure.")
def command(method: str | None, distance_m: float, **values: Any) -> int:
    """Measure the dead band, the velocities and the lag of the motors of a drive, and correct the robot's file.

    The robot turns its wheels at several duties, on a stand or in an open space. In a simulator, the true pose
    replaces the tape measure.
    """
    from robotcore.calibration.corrections import apply_corrections
    from robotcore.calibration.motors.measurement import Method, choose_method, measure_motors
    from robotcore.calibration.motors.motor_chart import build_motor_charts
    from robotcore.calibration.motors.motor_corrections import list_motor_corrections

    session = RobotSession(**values, default_world=OPEN)
    runner = build_runner(session)
    robot = runner.robot
    chosen = Method(method) if method else choose_method(runner)
    if chosen is not Method.TAPE:
        runner.prepare(FLOOR if chosen is Method.ENCODER else PIVOT)
    results = measure_motors(runner, chosen, distance_m)
    corrections = [each for result in results for each in list_motor_corrections(result, robot)]
    apply_corrections(session.changes, corrections)
    session.charts += build_motor_charts(results, robot.models)
    answer = _build_answer(chosen, results, corrections)
    return session.finish("The motors", answer, partial(_write_results, results, corrections, robot))


def _build_answer(method: Method, results: list[MotorResult], corrections: list[Correction]) -> dict[str, Any]:
    """Return the data about the motors for JSON.

    The JSON keys:

    method: text; the instrument: ``encoder``, ``imu`` or ``tape``.
    motors: object; the measured motors by their names.
    motors.MOTOR.*: robotcore.cli.calibrate.motors._to_dict
    corrections: list of objects; the values of the robot's file, and the measured ones.
    corrections[].*: robotcore.calibration.corrections.Correction.to_dict
    """
    return {
        "method": method.value,
        "motors": {each.motor: _to_dict(each) for each in results},
        "corrections": [each.to_dict() for each in corrections],
    }


def _write_results(results: list[MotorResult], corrections: list[Correction], robot: CalibratedRobot) -> None:
    from robotcore.calibration.least_squares import format_digits

    known = {(each.table[1], each.key): each for each in corrections}
    rows = [
        (result.motor, *cells)
        for result in results
        for cells in _list_cells(result, known, robot.full_rad_s, has_models=bool(robot.models))
    ]
    write_table(("motor", "property", "in the file", "measured", "±", ""), rows)
    write_line()
    for result in results:
        curve = result.curve
        write_line(
            f"{result.motor}, by {result.instrument}: R² {curve.r_squared:.5f}, residuals of "
            f"{format_digits(curve.residual_rad_s, 3)} rad/s at {len(curve.points)} commands"
        )

    if remark := _describe_lags(results, robot):
        write_line(remark)


def _describe_lags(results: list[MotorResult], robot: CalibratedRobot) -> str:
    """Return a sentence about motors with different lags; ``""`` if they have the same or if the robot steers."""
    from robotcore.calibration.motors.response import find_lag_difference_s

    drive = robot.description.drive
    assert drive
    responses = {each.motor: each.response for each in results if each.response}
    left, right = (
        [responses[name] for name in side if name in responses] for side in (drive.left_motors, drive.right_motors)
    )
    if robot.description.min_turn_radius_m or not (left and right):
        return ""
    if not (difference := find_lag_difference_s(left, right)):
        return ""
    later, earlier = ("left", "right") if difference > 0 else ("right", "left")
    reference = "the encoders" if drive.encoders else "an IMU that the app opens"
    return (
        f"The {later} wheels follow a command {abs(difference) * 1000:.0f} ms later than the {earlier} wheels, so the "
        f"robot turns to the {later} when it starts. The manoeuvre straight corrects this by {reference}: "
        'the page "Manoeuvres" of the documentation'
    )


def _list_cells(
    result: MotorResult, known: dict[tuple[str, str], Correction], full_rad_s: float, *, has_models: bool
) -> Iterator[tuple[str, ...]]:
    from robotcore.calibration.least_squares import format_digits

    curve, response = result.curve, result.response
    dead_band = curve.dead_band if has_models else curve.dead_band.scale(full_rad_s)
    properties: list[tuple[str, str, Estimate]] = [
        ("dead_band", "dead band, duty" if has_models else "dead band, rad/s", dead_band),
        ("forward_rad_s", "full forward, rad/s", curve.forward),
        ("backward_rad_s", "full backward, rad/s", curve.backward),
    ]
    if response:
        properties += [("lag_s", "lag, s", response.lag), ("", "delay, s", response.delay)]
    shown = {key for key, _, _ in properties}
    own = ((key, each.measured) for (name, key), each in known.items() if name == result.motor)
    properties += [(key, key.replace("_", " "), measured) for key, measured in own if key not in shown]
    for key, words, estimate in properties:
        correction = known.get((result.motor, key))
        old = f"{correction.old:g}" if correction else ""
        value = f"{correction.new:g}" if correction else format_digits(estimate.rounded, 6)
        is_wrong = correction is not None and correction.is_needed
        yield words, old, value, format_digits(estimate.deviation, 2), "differs" if is_wrong else ""


def _to_dict(result: MotorResult) -> dict[str, Any]:
    """Return the data about a motor for JSON.

    The JSON keys:

    instrument: text; the name of the encoder or of the IMU, or ``tape measure``.
    dead_band: object; the greatest duty at which the wheel does not turn, from 0 to 1.
    dead_band.*: robotcore.calibration.least_squares.Estimate
    forward_rad_s: object; the velocity at the duty 1, in rad/s.
    forward_rad_s.*: robotcore.calibration.least_squares.Estimate
    backward_rad_s: object; the velocity at the duty -1, in rad/s, as a positive number.
    backward_rad_s.*: robotcore.calibration.least_squares.Estimate
    lag_s: object; the time constant of the lag, in seconds. Only with an encoder or an IMU.
    lag_s.*: robotcore.calibration.least_squares.Estimate
    delay_s: object; the time from a command to its effect, in seconds. Only with an encoder or an IMU.
    delay_s.*: robotcore.calibration.least_squares.Estimate
    r_squared: number; the coefficient of determination of the fit, from 0 to 1.
    residual_rad_s: number, rad/s; the root mean square of the residuals.
    points: list of objects; the measured points.
    points[].command: number; the duty, or the share of the full command, from -1 to 1.
    points[].value: number, rad/s; the velocity.
    points[].deviation: number, rad/s; the standard deviation of the velocity.
    """
    curve, response = result.curve, result.response
    estimates = {"dead_band": curve.dead_band, "forward_rad_s": curve.forward, "backward_rad_s": curve.backward}
    if response:
        estimates |= {"lag_s": response.lag, "delay_s": response.delay}
    return {
        "instrument": result.instrument,
        **{key: each._asdict() for key, each in estimates.items()},
        "r_squared": curve.r_squared,
        "residual_rad_s": curve.residual_rad_s,
        "points": [{"command": each.command, **each.velocity._asdict()} for each in curve.points],
    }
