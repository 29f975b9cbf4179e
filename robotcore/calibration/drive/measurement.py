"""Measures the wheel radius and the track: by straight drives and by turns on the spot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from robotcore.calibration.calibrated_robot import EXCITATION_KINDS
from robotcore.calibration.drive.geometry_fit import (
    ALIGNMENT_RAD,
    Spin,
    StraightDrive,
    fit_radius,
    fit_radius_ratio,
    fit_track,
)
from robotcore.calibration.drive.room_profile import fit_full_turn
from robotcore.calibration.drive.straight_path import StraightPath
from robotcore.calibration.excitation import Excitation, ExcitationStep, Side, TruePoseObserver
from robotcore.calibration.excitation_runs import ExcitationRunner
from robotcore.calibration.least_squares import Array, Estimate, fit_linear
from robotcore.description import AckermannDrive
from robotcore.errors import CalibrationError, UsageError
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription

SPEED_M_S, TURN_RAD_S = 0.2, 1.0
"""The velocity of a straight drive, and the turn rate of a turn on the spot."""

MAX_SHARE = 0.6
"""The greatest share of the wheels' greatest velocity with which the robot drives."""

SETTLE_S, STAND_S = 1.0, 2.0
"""The rests after a straight drive, and before and after a turn, in seconds."""

TAPE_ERROR_M, TAPE_ERROR_RAD = 0.003, math.radians(1.0)
"""The standard deviations of a distance and of an angle that a person measures."""

GYRO_ERROR_RAD = math.radians(0.5)
WALL_ERROR_M = 0.005
"""The standard deviations of a turn by an IMU, and of a distance by a range sensor."""

COMMAND_ERROR = 0.01
"""The standard deviation of a wheel's angle without an encoder, as a share of it."""


class Reference(str, Enum):
    """The instrument with which a motion is compared."""

    TAPE = "tape"
    IMU = "imu"
    WALL = "wall"


@dataclass(frozen=True)
class DriveResult:
    """The measured geometry of a drive."""

    radius: Estimate
    """The mean wheel radius in metres."""
    track: Estimate | None
    """The track in metres, the effective one of wheels that skid. None for a robot that steers."""
    ratio: Estimate | None
    """The radius of the right wheel, divided by that of the left wheel."""
    drives: tuple[StraightDrive, ...]
    spins: tuple[Spin, ...]
    has_encoders: bool
    straight_by: Reference
    turns_by: Reference


def measure_drive(
    runner: ExcitationRunner, straight_by: Reference, turns_by: Reference, distance_m: float, turns: int
) -> DriveResult:
    """Drive the robot, and return the geometry of its drive.

    distance_m: the length of a straight drive, in metres.
    turns: the number of turns on the spot in each direction.

    Raises UsageError for a reference that the robot lacks, and CalibrationError if the motion cannot be measured.
    """
    robot, drive = runner.robot.description, runner.drive
    if turns_by is Reference.IMU and robot.first_of("imu") is None:
        raise _refuse("--turns-by imu", "the robot has no IMU")
    if Reference.WALL in (straight_by, turns_by) and robot.first_of("range_sensor") is None:
        raise _refuse("wall", "the robot has no range sensor")
    paths = _drive_to_wall(runner, distance_m) if straight_by is Reference.WALL else _drive_along(runner, distance_m)
    geometry = drive.geometry
    radius = _fit_radius(runner, [each.fit(geometry.wheel_radius / geometry.track) for each in paths])
    spins: list[Spin] = []
    track = None
    if not isinstance(drive, AckermannDrive):
        spins = _spin(runner, turns_by, turns, radius.value)
        track = fit_track(spins, radius, geometry.track)
    # The measured track shows better how the wheels have turned the robot.
    track_m = track.value if track else geometry.track
    drives = [each.fit(radius.value / track_m) for each in paths]
    radius = _fit_radius(runner, drives)
    track = fit_track(spins, radius, geometry.track) if spins else None
    ratio = _fit_ratio(runner, drives, radius.value, track_m)
    return DriveResult(
        radius, track, ratio, tuple(drives), tuple(spins), bool(drive.encoders), straight_by, turns_by
    )  # fmt: skip


def _fit_radius(runner: ExcitationRunner, drives: list[StraightDrive]) -> Estimate:
    radius = fit_radius(drives, runner.drive.wheel_radius_m)
    if runner.drive.encoders:
        return radius
    return Estimate(radius.value, math.hypot(radius.deviation, COMMAND_ERROR * radius.value))


def _fit_ratio(
    runner: ExcitationRunner, drives: list[StraightDrive], radius_m: float, track_m: float
) -> Estimate | None:
    """Return the ratio of the radii. Its uncertainty has a part of the encoders' resolution, or of the commands."""
    encoders = [
        each for each in runner.robot.description.all_of(EncoderDescription) if each.name in runner.drive.encoders
    ]
    count_rad = max((math.tau / each.counts_per_turn for each in encoders), default=0.0)
    # The error of a wheel's angle is uniform within a count. It turns the whole path.
    ratio = fit_radius_ratio(drives, track_m, math.hypot(ALIGNMENT_RAD, count_rad / math.sqrt(6) * radius_m / track_m))
    if ratio is None or encoders:
        return ratio
    return Estimate(ratio.value, math.hypot(ratio.deviation, math.sqrt(2) * COMMAND_ERROR))


def _drive_along(runner: ExcitationRunner, distance_m: float) -> list[StraightPath]:
    speed = min(SPEED_M_S, MAX_SHARE * _fastest_m_s(runner))
    paths = []
    for number, direction in enumerate((1, -1), start=1):
        command = direction * speed / _fastest_m_s(runner)
        title = f"straight drive {number} of 2"
        moved, excitation = runner.drive_straight(command, distance_m / speed, SETTLE_S, title, takes_duties=False)
        times, left = _read_wheel(runner, excitation, "left")
        right = np.interp(times, *_read_wheel(runner, excitation, "right"))
        paths.append(StraightPath(left, right, moved.forward_m, moved.left_m, TAPE_ERROR_M))
    return paths


def _drive_to_wall(runner: ExcitationRunner, distance_m: float) -> list[StraightPath]:
    nose = runner.robot.description.first_of("range_sensor")
    runner.prepare(
        f"Put the robot {distance_m + 0.4:.1f} m in front of a wall, and let it face the wall at a right angle. It "
        f"drives {distance_m:g} m to the wall and back"
    )
    speed = min(SPEED_M_S, MAX_SHARE * _fastest_m_s(runner))
    command, duration = speed / _fastest_m_s(runner), distance_m / speed
    rest = ExcitationStep(STAND_S)
    steps = [rest, ExcitationStep(duration, command, command), rest, ExcitationStep(duration, -command, -command), rest]
    excitation = runner.excite(steps, takes_duties=False, kinds=EXCITATION_KINDS | {"range_sensor"})
    edges = excitation.log.edges
    stands = [(edges[number] + STAND_S / 2, edges[number + 1]) for number in (0, 2, 4)]
    times, distances = excitation.log.read_series(nose.name)
    at = [_average(times, distances, stand, nose.name) for stand in stands]
    paths = []
    for first, then in ((0, 1), (1, 2)):
        left, right = (_read_wheel(runner, excitation, side) for side in ("left", "right"))
        within = (left[0] >= stands[first][0]) & (left[0] <= stands[then][1])
        angles = left[1][within], np.interp(left[0][within], *right)
        paths.append(StraightPath(*angles, at[first] - at[then], None, WALL_ERROR_M))
    return paths


def _average(times: Array, distances: Array, stand: tuple[float, float], sensor: str) -> float:
    values = distances[(times >= stand[0]) & (times <= stand[1])]
    values = values[np.isfinite(values)]
    if not len(values):
        text = f"{sensor} measures no wall. Put the robot in front of a wall within its range, or give less --distance"
        raise CalibrationError(text, kind="no-wall", device=sensor)
    return float(np.median(values))


def _spin(runner: ExcitationRunner, turns_by: Reference, turns: int, radius_m: float) -> list[Spin]:
    track = runner.drive.geometry.track
    if turns_by is Reference.TAPE and not runner.robot.is_simulated:
        # A person reads only the last part of a turn. So the first estimate must be right to half a turn.
        first = _spin_once(runner, turns_by, 1, track, radius_m, "first turn")
        track = fit_track([first], Estimate(radius_m, 0.0), track).value
    left = _spin_once(runner, turns_by, turns, track, radius_m, "turns to the left")
    return [left, _spin_once(runner, turns_by, -turns, track, radius_m, "turns to the right")]


def _spin_once(
    runner: ExcitationRunner, turns_by: Reference, turns: int, track_m: float, radius_m: float, title: str
) -> Spin:
    """Turn on the spot, and return the turn.

    turns: the number of turns, positive to the left.
    track_m, radius_m: the best estimates so far, which decide how long the wheels turn.
    """
    direction, fastest = (1 if turns > 0 else -1), runner.robot.max_velocity_rad_s
    wheel_rad_s = min(TURN_RAD_S * track_m / 2 / radius_m, MAX_SHARE * fastest)
    duration = abs(turns) * math.tau * track_m / 2 / radius_m / wheel_rad_s
    command, rest = direction * wheel_rad_s / fastest, ExcitationStep(STAND_S)
    where = "Put the robot on the floor with free space around it"
    mark = ", along a straight line" if turns_by is Reference.TAPE else ""
    near = ", within 1 m of a wall" if turns_by is Reference.WALL else ""
    instruction = f"{title}: {where}{mark}{near}. It turns {abs(turns)} times on the spot"
    runner.prepare(instruction, has_question=turns_by is Reference.TAPE)
    observer = TruePoseObserver()
    kinds = EXCITATION_KINDS | ({"range_sensor"} if turns_by is Reference.WALL else set())
    steps = [rest, ExcitationStep(duration, -command, command), rest]
    excitation = runner.excite(steps, [observer], takes_duties=False, kinds=kinds)
    left, right = (_measure_wheel(runner, excitation, side) for side in ("left", "right"))
    measure: dict[Reference, Callable[[], Estimate]] = {
        Reference.TAPE: lambda: _ask_turn(runner, observer, turns, title),
        Reference.IMU: lambda: _read_gyro(runner, excitation),
        Reference.WALL: lambda: _compare_distances(runner, excitation, track_m, radius_m),
    }
    turn = measure[turns_by]()
    return Spin(left, right, turn.value, turn.deviation)


def _ask_turn(runner: ExcitationRunner, observer: TruePoseObserver, turns: int, title: str) -> Estimate:
    if (turned := runner.read_turn(observer)) is not None:
        return Estimate(turned, TAPE_ERROR_RAD)
    beyond = runner.person.ask(
        f"{title}: the angle from the line to the robot's direction now, in degrees, positive to the left"
    )
    return Estimate(turns * math.tau + math.radians(beyond), TAPE_ERROR_RAD)


def _read_gyro(runner: ExcitationRunner, excitation: Excitation) -> Estimate:
    """Return the turn by the IMU, without the drift that it has in both rests."""
    times, headings = excitation.log.read_series(runner.robot.description.first_of("imu").name)
    edges = excitation.log.edges
    rests = [(times >= edges[0]) & (times <= edges[1]), (times >= edges[2] + STAND_S / 2) & (times <= edges[3])]
    columns = [np.where(rest, 1.0, 0.0) for rest in rests]
    used = rests[0] | rests[1]
    fit = fit_linear(np.column_stack([*columns, times - edges[1]])[used], headings[used])
    start, end, _ = fit.estimates
    return Estimate(end.value - start.value, math.hypot(start.deviation, end.deviation, GYRO_ERROR_RAD))


def _compare_distances(runner: ExcitationRunner, excitation: Excitation, track_m: float, radius_m: float) -> Estimate:
    """Return the turn by the repetition of the measured distances."""
    edges = excitation.log.edges
    times, distances = excitation.log.read_series(runner.robot.description.first_of("range_sensor").name)
    left, right = (np.interp(times, *_read_wheel(runner, excitation, side)) for side in ("left", "right"))
    turned = (right - left) * radius_m / track_m
    moving = (times >= edges[1]) & (times <= edges[2])
    full = fit_full_turn(turned[moving], distances[moving])
    whole = float(turned[-1] - turned[0])
    return Estimate(whole * math.tau / full.value, abs(whole) * math.tau / full.value**2 * full.deviation)


def _measure_wheel(runner: ExcitationRunner, excitation: Excitation, side: Side) -> float:
    """Return the angle by which the wheels of a side have turned in an excitation, in radians."""
    _, angles = _read_wheel(runner, excitation, side)
    return float(angles[-1] - angles[0])


def _read_wheel(runner: ExcitationRunner, excitation: Excitation, side: Side) -> tuple[Array, Array]:
    """Return the times and the mean angles of the wheels of a side, by the encoders, or else by the commands."""
    drive = runner.drive
    encoders = drive.left_encoders if side == "left" else drive.right_encoders
    if not encoders:
        names = drive.left_motors if side == "left" else drive.right_motors
        lags = [each.lag_s for each in runner.robot.description.all_of(MotorDescription) if each.name in names]
        return excitation.log.integrate_sent(side, float(np.mean(lags)))
    series = [excitation.log.read_series(name) for name in encoders]
    times = series[0][0]
    return times, np.mean([np.interp(times, *each) for each in series], axis=0)


def _fastest_m_s(runner: ExcitationRunner) -> float:
    return runner.robot.max_velocity_rad_s * runner.drive.wheel_radius_m


def _refuse(option: str, reason: str) -> UsageError:
    text = f"{option}: {reason}. Take another reference"
    return UsageError(text, kind="reference-missing")
