"""A drive as the app uses it: two motors behind the command filter, and odometry."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import cast

from robotcore.description import Drive, EncoderDescription, RobotDescription
from robotcore.geometry import Wheels, to_float
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Device, Encoder, Motor, RangeSensor
from robotcore.hal.drive import CommandIntegrator, DifferentialDrive, Odometry
from robotcore.runtime.layers.base import Layer
from robotcore.safety import (
    AccelerationLimit,
    CommandFilter,
    DistanceAhead,
    Latch,
    RangeGuard,
    Rule,
    SafetyFilter,
    StopGroup,
    StuckRangeCheck,
    VelocityLimit,
    WheelTrackingCheck,
)


class WheelMotor(Motor):
    """One wheel of a drive: what it is told passes the safety stage together with the other wheel's command.

    `set_velocity` returns what would be sent as the tick stands; a later command for the other wheel may still
    scale both.
    """

    def __init__(self, inner: Motor, stage: CommandFilter, *, is_left: bool) -> None:
        super().__init__(inner.name, inner.max_velocity)
        self._inner, self._stage, self._is_left = inner, stage, is_left

    def set_velocity(self, rad_s: float) -> float:
        self._require_open()
        rad_s, asked = to_float(rad_s), self._stage.asked
        if self._is_left:
            return self._stage.ask(Wheels(rad_s, asked.right)).left
        return self._stage.ask(Wheels(asked.left, rad_s)).right

    def stop(self) -> None:
        """Stop the whole drive at once: one wheel that stops alone would throw the robot round."""
        if not self._is_closed:
            self._stage.stop()

    def close(self) -> None:
        try:
            self._inner.close()
        finally:
            self._is_closed = True

    def _apply(self, rad_s: float) -> None:
        self.set_velocity(rad_s)


@dataclass(frozen=True)
class GuardedDrive:
    """A drive with the stage that its commands pass; ``motors`` stand before the driver's own.

    ``suspend`` stops it between two ticks, past the layers over its stage: it is no command of the app's.
    """

    drive: DifferentialDrive
    stage: CommandFilter
    suspend: Callable[[str], None]
    motors: dict[str, Device]

    @classmethod
    def over(
        cls,
        devices: Mapping[str, Device],
        description: RobotDescription,
        drive: Drive,
        clock: Clock,
        latch: Latch,
        rate_hz: float,
        layers: Sequence[Layer],
        brakes: StopGroup,
    ) -> GuardedDrive:
        """Build the drive that ``description`` tells of over the devices that are open, ``layers`` over its stage.

        ``brakes`` are those on the robot's motors.
        """
        left, right = _motor(devices, drive.left), _motor(devices, drive.right)
        limit = min(left.max_velocity, right.max_velocity)
        commanded = CommandIntegrator(clock)
        encoders = _encoders(devices, drive)
        counted = _counted(*encoders) if encoders else None
        ahead = _sensors_ahead(devices, description)
        doubts: list[Rule] = []
        if counted:
            doubts.append(_following(description, drive, clock, latch, commanded.angles, counted))
            doubts.append(
                StuckRangeCheck(latch, ahead, Odometry(drive.geometry, counted).pose, description.safety.stuck_m)
            )
        bare = SafetyFilter(
            clock,
            left,
            right,
            (*doubts, *_rules(ahead, clock, description, drive, limit, rate_hz)),
            description.safety.lease_ticks / rate_hz,
            latch,
            commanded.turn_at,
            brakes.of(left, right),
        )
        stage = reduce(lambda stage, layer: layer.command_filter(stage), layers, cast("CommandFilter", bare))
        reckoned = _up_to_date(*encoders, commanded) if encoders else commanded.angles
        angles = reduce(lambda read, layer: layer.angles(read), layers, reckoned)
        odometry = Odometry(drive.geometry, angles)
        motors: dict[str, Device] = {
            left.name: WheelMotor(left, stage, is_left=True),
            right.name: WheelMotor(right, stage, is_left=False),
        }
        reach = description.body.reach_m
        return cls(DifferentialDrive(drive.geometry, stage, odometry, limit, reach), stage, bare.suspend, motors)


def _rules(
    sensors: Sequence[RangeSensor],
    clock: Clock,
    description: RobotDescription,
    drive: Drive,
    limit: float,
    rate_hz: float,
) -> Iterator[Rule]:
    """Yield the rules in their order; the guard is last, for nothing may weaken it."""
    yield VelocityLimit(limit)
    if drive.max_acceleration_rad_s2:
        yield AccelerationLimit(drive.max_acceleration_rad_s2 / rate_hz)
    if sensors:
        safety = description.safety
        ahead = DistanceAhead(clock, sensors)
        yield RangeGuard(drive.geometry, ahead, safety.stop_distance_m, safety.deceleration_m_s2)


def _sensors_ahead(devices: Mapping[str, Device], description: RobotDescription) -> list[RangeSensor]:
    opened = (devices.get(sensor.name) for sensor in description.range_sensors_ahead)
    return [device for device in opened if isinstance(device, RangeSensor)]


def _encoders(devices: Mapping[str, Device], drive: Drive) -> tuple[Encoder, Encoder] | None:
    left, right = devices.get(drive.left_encoder or ""), devices.get(drive.right_encoder or "")
    return (left, right) if isinstance(left, Encoder) and isinstance(right, Encoder) else None


def _counted(left: Encoder, right: Encoder) -> Callable[[], Wheels]:
    return lambda: Wheels(left.read().angle, right.read().angle)


def _up_to_date(left: Encoder, right: Encoder, commanded: CommandIntegrator) -> Callable[[], Wheels]:
    """Return what reads the angles of now: what a late count has not got to yet, the wheels did as they were told."""

    def angles() -> Wheels:
        on_left, on_right = left.read(), right.read()
        return Wheels(
            on_left.angle + commanded.rotation_since(on_left.time).left,
            on_right.angle + commanded.rotation_since(on_right.time).right,
        )

    return angles


def _following(
    description: RobotDescription,
    drive: Drive,
    clock: Clock,
    latch: Latch,
    commanded: Callable[[], Wheels],
    turned: Callable[[], Wheels],
) -> WheelTrackingCheck:
    motors, encoders = (drive.left, drive.right), (drive.left_encoder or "", drive.right_encoder or "")
    counts = [
        math.tau / each.counts_per_turn for each in description.all_of(EncoderDescription) if each.name in encoders
    ]
    return WheelTrackingCheck(
        clock, latch, commanded, turned, motors, encoders, description.safety.follow_s, max(counts)
    )


def _motor(devices: Mapping[str, Device], name: str) -> Motor:
    motor = devices[name]
    assert isinstance(motor, Motor), f"{name} is a {type(motor).__name__}, the description says motor"
    return motor
