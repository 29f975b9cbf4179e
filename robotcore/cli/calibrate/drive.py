"""``robotcore calibrate drive``: measure the wheel radius and the track of a robot."""

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
    from robotcore.calibration.corrections import Correction
    from robotcore.calibration.drive.measurement import DriveResult
    from robotcore.description import Drive


@click.command("drive", cls=MeasuringCommand, short_help="Measure the wheel radius and the track.")
@robot_session_options(OPEN)
@click.option(
    "--straight-by",
    type=click.Choice(["tape", "wall"]),
    default="tape",
    show_default=True,
    help="The reference of the straight drives: a tape measure, or a wall in front of the first range sensor.",
)
@click.option(
    "--turns-by",
    type=click.Choice(["tape", "imu", "wall"]),
    help="The reference of the turns: an angle that you measure, the IMU, or the distances around the robot. "
    "Default: the IMU, else tape.",
)
@distance_option(most_m=20, default_m=2.0, text="The length of a straight drive.")
@click.option(
    "--turns",
    type=click.IntRange(1, 20),
    default=5,
    show_default=True,
    help="The number of turns on the spot in each direction.",
)
def command(straight_by: str, turns_by: str | None, distance_m: float, turns: int, **values: Any) -> int:
    """Measure the wheel radius and the track of a robot, and correct the robot's file.

    The robot drives straight, and turns on the spot. Calibrate the motors first. In a simulator, the true pose
    replaces the tape measure.
    """
    from robotcore.calibration.corrections import apply_corrections
    from robotcore.calibration.drive.drive_chart import build_drive_charts
    from robotcore.calibration.drive.drive_corrections import list_drive_corrections
    from robotcore.calibration.drive.measurement import Reference, measure_drive

    session = RobotSession(**values, default_world=OPEN)
    runner = build_runner(session)
    turn_reference = Reference(turns_by or ("imu" if session.description.first_of("imu") else "tape"))
    result = measure_drive(runner, Reference(straight_by), turn_reference, distance_m, turns)
    corrections = list_drive_corrections(result, runner.drive)
    apply_corrections(session.changes, corrections)
    session.charts += build_drive_charts(result, runner.drive)
    answer = _build_answer(result, corrections)
    return session.finish("The drive", answer, partial(_write_result, result, corrections, runner.drive))


def _write_result(result: DriveResult, corrections: list[Correction], drive: Drive) -> None:
    from robotcore.calibration.least_squares import format_digits

    rows = (
        (
            each.key,
            f"{each.old:g}",
            f"{each.new:g}",
            format_digits(each.measured.deviation, 2),
            "differs" * each.is_needed,
        )
        for each in corrections
    )
    write_table(("property", "in the file", "measured", "±", ""), rows)
    write_line()
    for line in _list_remarks(result, drive):
        write_line(line)


def _list_remarks(result: DriveResult, drive: Drive) -> Iterator[str]:
    from robotcore.description import AckermannDrive, SkidDrive

    radius = result.radius.value
    errors = [1000 * (each.way_m - radius * each.mean_rad) for each in result.drives]
    yield f"straight drives by {result.straight_by.value}: residuals of {_join(errors, '.1f')} mm"
    if result.track:
        turns = [57.3 * (each.turn_rad - radius * each.difference_rad / result.track.value) for each in result.spins]
        yield f"turns by {result.turns_by.value}: residuals of {_join(turns, '.2f')} degrees"
    if not result.has_encoders:
        yield (
            "The wheels have no encoders, so the velocities and the lags of the motors in the file must be right: "
            "robotcore calibrate motors"
        )
    if result.ratio and abs(result.ratio.value - 1) > 2 * result.ratio.deviation:
        yield (
            f"The radius of the right wheels is {result.ratio.value:.4f} ± {result.ratio.deviation:.4f} of that of the "
            "left wheels. The file has one radius, which is the mean"
        )
    if isinstance(drive, SkidDrive):
        yield "track_factor holds for this floor. Measure it again on another one"
    if isinstance(drive, AckermannDrive):
        yield "Not measured: track_m, wheelbase_m, and the angles of the steering servo"


def _join(values: list[float], form: str) -> str:
    return " and ".join(f"{each:{form}}" for each in values)


def _build_answer(result: DriveResult, corrections: list[Correction]) -> dict[str, Any]:
    """Return the data about the drive for JSON.

    The JSON keys:

    wheel_radius_m: object; the mean wheel radius, in metres.
    wheel_radius_m.*: robotcore.calibration.least_squares.Estimate
    effective_track_m: object or null; the track in metres, the effective one of wheels that skid.
    effective_track_m.*: robotcore.calibration.least_squares.Estimate
    radius_ratio: object or null; the radius of the right wheels, divided by that of the left wheels.
    radius_ratio.*: robotcore.calibration.least_squares.Estimate
    straight_by: text; the reference of the straight drives: ``tape`` or ``wall``.
    turns_by: text; the reference of the turns: ``tape``, ``imu`` or ``wall``.
    straight_drives: list of objects; the straight drives.
    straight_drives[].*: robotcore.calibration.drive.geometry_fit.StraightDrive
    spins: list of objects; the turns on the spot.
    spins[].*: robotcore.calibration.drive.geometry_fit.Spin
    corrections: list of objects; the values of the robot's file, and the measured ones.
    corrections[].*: robotcore.calibration.corrections.Correction.to_dict
    """
    estimates = {"wheel_radius_m": result.radius, "effective_track_m": result.track, "radius_ratio": result.ratio}
    return {
        **{key: each and each._asdict() for key, each in estimates.items()},
        "straight_by": result.straight_by.value,
        "turns_by": result.turns_by.value,
        "straight_drives": [vars(each) for each in result.drives],
        "spins": [vars(each) for each in result.spins],
        "corrections": [each.to_dict() for each in corrections],
    }
