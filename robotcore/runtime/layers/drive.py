"""Builds the app's drive: two motors behind the command filter, and the odometry."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from robotcore.description import RobotDescription, TwoWheelDrive
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.device import Device
from robotcore.hal.drive import CommandIntegrator, DifferentialDrive, Odometry
from robotcore.hal.joint import Joints
from robotcore.kinds.encoder import Encoder, EncoderDescription
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.runtime.layers.base import MotorOutput, Tap
from robotcore.safety.command_filter import CommandFilter, SafetyFilter
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.range_guard import DistanceAhead, RangeGuard
from robotcore.safety.sensor_checks import StuckRangeCheck, WheelTrackingCheck
from robotcore.safety.velocity_limits import AccelerationLimit, Rule, VelocityLimit


class GuardedDrive(NamedTuple):
    """A drive, and the command filter that limits its commands."""

    drive: DifferentialDrive
    command_filter: CommandFilter
    """The safety filter, wrapped by the taps. The drive sends the app's commands to it."""
    suspend: Callable[[str], None]
    """Stops the drive between two ticks. The argument is the cause of the intervention."""


def build_drive(
    devices: Mapping[str, Device],
    wheels: tuple[MotorOutput, MotorOutput],
    limit: float,
    description: RobotDescription,
    drive: TwoWheelDrive,
    clock: Clock,
    latch: Latch,
    rate_hz: float,
    taps: Sequence[Tap],
    motor_stops: StopGroup,
    joints: Joints,
    take_guardian_stops: Callable[[], int],
) -> GuardedDrive:
    """Build the drive and its command filter.

    devices: the app's devices. The drive uses their encoders and range sensors.
    wheels: the outputs of the left and the right motor.
    limit: the largest velocity of each wheel, in rad/s.
    description: the robot's description, with the safety limits.
    drive: the description of the drive.
    taps: the taps that get the drive's commands and the wheel angles.
    motor_stops: stops the robot's motors.
    joints: the assumed motion of the servos, which may turn range sensors.
    take_guardian_stops: a function that returns the number of stops by the guardian since its last call.
    """
    safety, commanded = description.safety, CommandIntegrator(clock)
    opened = [devices.get(sensor.name) for sensor in description.range_sensors_ahead]
    ahead = [device for device in opened if isinstance(device, RangeSensor)]
    mounts = description.mounts
    fixed = [sensor for sensor in ahead if not mounts[sensor.name].on]
    measured: Callable[[], Wheels] = commanded.angles
    rules: list[Rule] = []
    match devices.get(drive.left_encoder or ""), devices.get(drive.right_encoder or ""):
        case Encoder() as left, Encoder() as right:
            measured = _read_present_angles(left, right, commanded)

            def count() -> Wheels:
                return Wheels(left.read().angle, right.read().angle)

            motors, encoders = (drive.left, drive.right), (left.name, right.name)
            steps = [
                math.tau / each.counts_per_turn
                for each in description.all_of(EncoderDescription)
                if each.name in encoders
            ]
            rules = [
                WheelTrackingCheck(
                    clock, latch, commanded.angles, count, motors, encoders, safety.follow_s, max(steps)
                ),
                StuckRangeCheck(latch, fixed, Odometry(drive.geometry, count).pose, safety.stuck_m),
            ]
    rules.append(VelocityLimit(limit))
    if drive.max_acceleration_rad_s2:
        rules.append(AccelerationLimit(drive.max_acceleration_rad_s2 / rate_hz))
    if ahead:  # last, so that no other rule changes its result
        are_fixed = len(fixed) == len(ahead)
        is_ahead = None if are_fixed else lambda sensor: joints.locate(mounts[sensor.name]).is_ahead
        distance = DistanceAhead(clock, ahead, is_ahead)
        rules.append(RangeGuard(drive.geometry, distance, safety.stop_distance_m, safety.deceleration_m_s2))
    safety_filter = SafetyFilter(
        clock,
        *wheels,
        rules,
        safety.lease_ticks / rate_hz,
        latch,
        commanded.turn_at,
        motor_stops.select(*wheels),
        take_guardian_stops,
    )
    command_filter: CommandFilter = safety_filter
    for tap in taps:
        command_filter, measured = tap.command_filter(command_filter), tap.angles(measured)
    odometry = Odometry(drive.geometry, measured)
    guarded = DifferentialDrive(drive.geometry, command_filter, odometry, limit, description.body.reach_m)
    return GuardedDrive(guarded, command_filter, safety_filter.suspend)


def _read_present_angles(left: Encoder, right: Encoder, commanded: CommandIntegrator) -> Callable[[], Wheels]:
    """Return a function that returns the present wheel angles in radians.

    The present angle is the encoder's angle plus the rotation that was commanded since the sample was captured.
    """

    def read() -> Wheels:
        on_left, on_right = left.read(), right.read()
        return Wheels(
            on_left.angle + commanded.rotation_since(on_left.time).left,
            on_right.angle + commanded.rotation_since(on_right.time).right,
        )

    return read
