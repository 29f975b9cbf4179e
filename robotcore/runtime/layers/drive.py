"""Builds the app's drive: the motors behind the command filter, and the odometry."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

from robotcore.description import AckermannDrive, Drive, RobotDescription
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.device import Device, Sensor
from robotcore.hal.drive import CommandIntegrator, DifferentialDrive, Odometry, WheelPath
from robotcore.hal.joint import Joints
from robotcore.kinds.encoder import Encoder, EncoderDescription
from robotcore.kinds.motor import VelocityOutput
from robotcore.runtime.layers.base import Send, Tap
from robotcore.runtime.layers.encoder_polling import EncoderPolling, TimedAngles, find_encoders
from robotcore.runtime.layers.timing import TickTimer
from robotcore.runtime.layers.wheel_angles import (
    PolledAngles,
    PresentAngles,
    ReadCourse,
    SteeredAngles,
    WheelPathReader,
    read_angles,
)
from robotcore.safety.command_filter import CommandFilter, SafetyFilter
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.range_guard import DistanceAhead, RangeGuard
from robotcore.safety.sensor_ahead import SensorAhead
from robotcore.safety.sensor_checks import StuckRangeCheck, WheelTrackingCheck
from robotcore.safety.velocity_limits import AccelerationLimit, ArcAccelerationLimit, Rule, SteeringLimit, VelocityLimit
from robotcore.safety.wheel_output import AxleMotor, SideMotors, SteeredWheels, WheelOutput


class GuardedDrive(NamedTuple):
    """A drive, and the command filter that limits its commands."""

    drive: DifferentialDrive
    command_filter: CommandFilter
    """The safety filter, wrapped by the taps. The drive sends the app's commands to it."""
    suspend: Callable[[str], None]
    """Stops the drive between two ticks. The argument is the cause of the intervention."""


def build_drive(
    devices: Mapping[str, Device],
    output: WheelOutput,
    limit: float,
    description: RobotDescription,
    drive: Drive,
    clock: Clock,
    latch: Latch,
    rate_hz: float,
    taps: Sequence[Tap],
    motor_stops: StopGroup,
    joints: Joints,
    take_guardian_stops: Callable[[], int],
    timer: TickTimer | None,
    polling: EncoderPolling | None,
) -> GuardedDrive:
    """Build the drive and its command filter.

    devices: the app's devices. The drive uses their encoders, and the sensors that look ahead.
    output: the output of the motors, and of the servo that steers.
    limit: the largest velocity of each wheel, in rad/s.
    description: the robot's description, with the safety limits.
    drive: the description of the drive.
    taps: the taps that get the drive's commands and the path of the wheels.
    motor_stops: stops the robot's motors.
    joints: the assumed motion of the servos, which may turn sensors or steer.
    take_guardian_stops: a function that returns the number of stops by the guardian since its last call.
    timer: measures the time of the rules.
    polling: the polls of the encoders between the ticks.
    """
    safety, commanded = description.safety, CommandIntegrator(clock)
    opened = [devices.get(each.name) for each in description.sensors_ahead]
    ahead = [SensorAhead(device, description, joints) for device in opened if isinstance(device, Sensor)]
    fixed = [sensor for sensor in ahead if sensor.is_fixed]
    left, right = find_encoders(devices, drive.left_encoders), find_encoders(devices, drive.right_encoders)
    steer = partial(_steer_angles, drive, joints, clock, is_measured=bool(left and right) and left != right)
    rules: list[Rule] = []
    measured = _time_angles(commanded.angles, clock)
    if left and right:
        read_present = PresentAngles(left, right, commanded, clock)
        measured = (
            PolledAngles(read_present, polling, commanded, clock) if polling else _time_angles(read_present, clock)
        )
        checked = steer(_time_angles(partial(read_angles, left, right), clock))  # one arc a tick is enough for a check
        rules = [
            *_build_tracking_checks(description, drive, left, right, clock, latch, commanded),
            StuckRangeCheck(
                latch, fixed, Odometry(drive.geometry, WheelPathReader(checked, drive.geometry)).pose, safety.stuck_m
            ),
        ]
    counts = _compute_counts(description)
    count = max((counts[each.name] for each in (*left, *right)), default=0.0)
    read_path: Callable[[], WheelPath] = WheelPathReader(steer(measured), drive.geometry, count)
    can_turn_on_spot = not description.min_turn_radius_m
    if not can_turn_on_spot:  # first, so that no other rule slows the robot down for a turn that it cannot make
        rules.append(SteeringLimit(*(curvature * drive.track_m / 2 for curvature in description.curvatures)))
    rules.append(VelocityLimit(limit))
    if drive.max_acceleration_rad_s2:
        limit_acceleration = AccelerationLimit if can_turn_on_spot else ArcAccelerationLimit
        rules.append(limit_acceleration(drive.max_acceleration_rad_s2 / rate_hz))
    if ahead:  # last, so that no other rule changes its result
        distance = DistanceAhead(clock, ahead, lambda: drive.geometry.to_twist(commanded.angles()))
        rules.append(
            RangeGuard(
                drive.geometry, distance, description.guard_distance_m, safety.deceleration_m_s2, can_turn_on_spot
            )
        )
    safety_filter = SafetyFilter(
        clock,
        output,
        rules,
        safety.lease_ticks / rate_hz,
        latch,
        commanded.turn_at,
        motor_stops.select(*output.motors),
        take_guardian_stops,
        *([timer.wrap_rules] if timer else []),
    )
    command_filter: CommandFilter = safety_filter
    for tap in taps:
        command_filter, read_path = tap.command_filter(command_filter), tap.wheel_path(read_path)
    odometry = Odometry(drive.geometry, read_path)
    guarded = DifferentialDrive(
        drive.geometry,
        command_filter,
        odometry,
        limit,
        description.body.reach_m,
        description.min_turn_radius_m,
        drive.track_m / 2,
        (drive.max_acceleration_rad_s2 or math.inf) * drive.wheel_radius_m,
        safety.deceleration_m_s2,
    )
    return GuardedDrive(guarded, command_filter, safety_filter.suspend)


def build_output(drive: Drive, motors: Mapping[str, VelocityOutput], steer: Send | None) -> WheelOutput:
    """Return the output of a drive.

    motors: the outputs of the motors by name.
    steer: the function that sends the angle of the servo that steers, if there is one.
    """
    left, right = ([motors[name] for name in names] for names in (drive.left_motors, drive.right_motors))
    output: WheelOutput = AxleMotor(left[0]) if left == right else SideMotors(left, right)
    if steer and isinstance(drive, AckermannDrive):
        to_angle_rad = drive.to_angle_rad
        return SteeredWheels(output, lambda curvature: steer(to_angle_rad(curvature)), drive.track_m)
    return output


def _time_angles(read: Callable[[], Wheels], clock: Clock) -> ReadCourse:
    return lambda: (TimedAngles(clock.now(), read()),)


def _steer_angles(drive: Drive, joints: Joints, clock: Clock, read: ReadCourse, *, is_measured: bool) -> ReadCourse:
    """Return a function that reads the wheel angles, for a robot that steers with the steering angle.

    is_measured: whether an encoder measures each wheel, so that the steering angle does not count.
    """
    if drive.steering_servo is None or is_measured:
        return read
    return SteeredAngles(read, joints[drive.steering_servo], clock, drive.track_m / 2 / drive.wheelbase)


def _compute_counts(description: RobotDescription) -> dict[str, float]:
    """Return the rotation of a wheel for one count of each encoder, in rad."""
    return {each.name: math.tau / each.counts_per_turn for each in description.all_of(EncoderDescription)}


def _build_tracking_checks(
    description: RobotDescription,
    drive: Drive,
    left: Sequence[Encoder],
    right: Sequence[Encoder],
    clock: Clock,
    latch: Latch,
    commanded: CommandIntegrator,
) -> Iterator[WheelTrackingCheck]:
    """Yield a check for each pair of encoders. A side with fewer encoders repeats its last one."""
    counts = _compute_counts(description)
    count = max(len(left), len(right))
    for pair in zip(*(([*side] + [side[-1]] * count)[:count] for side in (left, right)), strict=True):
        yield WheelTrackingCheck(
            clock,
            latch,
            commanded.angles,
            partial(read_angles, pair[:1], pair[1:]),
            (drive.motor_by_device[pair[0].name], drive.motor_by_device[pair[1].name]),
            (pair[0].name, pair[1].name),
            description.safety.follow_s,
            max(counts[each.name] for each in pair),
        )
