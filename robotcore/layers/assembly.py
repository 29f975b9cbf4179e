"""The one place that puts the layers over a robot's devices, in this order.

Sensors: driver → conditions → age → one sample a tick → app. Motors: app → safety → deadman → conditions → driver.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from robotcore.clock import AppClock, Clock, TickClock
from robotcore.description import CameraDescription, Conditions, Drive, RangeSensorDescription, RobotDescription
from robotcore.devices import Camera, Device, Display, Encoder, Motor, RangeSensor, SampleT
from robotcore.errors import UnknownNameError, UnmetNeedError
from robotcore.geometry import Pose
from robotcore.layers.conditions import PERFECT, conditioned_camera, conditioned_motor, conditioned_range
from robotcore.layers.devices import LayeredCamera, LayeredDisplay, LayeredEncoder, LayeredRangeSensor
from robotcore.layers.readers import Fresh, OnceATick, Reader
from robotcore.layers.wheels import GuardedDrive
from robotcore.robot import Robot, Role
from robotcore.safety import Latch, SafetyStage

_KINDS = {Role.CAMERA: "camera", Role.RANGE: "range_sensor", Role.DISPLAY: "display"}
_MOUNTED = (CameraDescription, RangeSensorDescription)


@dataclass(frozen=True)
class Assembled:
    """A robot as an app gets it, the clock that its loop ticks, the latch that ends its run, its drive's stage."""

    robot: Robot
    clock: TickClock
    latch: Latch
    stage: SafetyStage | None


def needed_devices(description: RobotDescription, needs: Iterable[Role], wants: Iterable[Role] = ()) -> frozenset[str]:
    """Return the names of the devices to open; ``wants`` are opened where the robot has them.

    A drive brings its motors, its encoders, and the range sensors that look ahead, for the guard. Raises
    UnmetNeedError where a need cannot be met.
    """
    names: set[str] = set()
    for role in sorted(map(_role, needs)):
        if not (found := _names_for(description, role)):
            raise UnmetNeedError(
                f"the robot {description.name!r} has no {role.value}, which the app needs; "
                "take another robot with --robot, or add it to the description"
            )
        names |= found
    return frozenset(names.union(*(_names_for(description, _role(role)) for role in wants)))


def assemble(
    raw: Robot,
    description: RobotDescription,
    rate_hz: float,
    clock: Clock | None = None,
    conditions: Conditions = PERFECT,
    seed: int = 0,
) -> Assembled:
    """Put every layer over a robot that a backend opened; ``clock`` stands in for the backend's own.

    The noise of the ``conditions`` belongs to the ``seed``.
    """
    ticks = TickClock(clock or raw.clock)
    latch = Latch()
    layers = _SensorLayers(ticks, description.safety.max_age_s, latch, conditions, seed)
    devices = {device.name: layers.over(device) for device in raw.devices.values()}
    for sensor in description.devices:
        device = devices.get(sensor.name)
        if isinstance(sensor, _MOUNTED) and isinstance(device, (Camera, RangeSensor)):
            device.mount = Pose(sensor.mount.x_m, sensor.mount.y_m, sensor.mount.yaw_rad)
    guarded = None
    drive = description.drive
    if drive and drive.left in raw.devices and drive.right in raw.devices:
        devices |= _conditioned_wheels(devices, drive, conditions)
        guarded = GuardedDrive.over(devices, description, drive, ticks, latch, rate_hz)
        devices |= guarded.motors
    app_clock = AppClock(ticks)
    robot = Robot(raw.name, app_clock, devices.values(), drive=guarded.drive if guarded else None, release=raw.close)
    return Assembled(robot, ticks, latch, guarded.stage if guarded else None)


def _role(name: Role | str) -> Role:
    try:
        return Role(name)
    except ValueError:
        raise UnknownNameError("role in the app's needs", str(name), [role.value for role in Role]) from None


def _names_for(description: RobotDescription, role: Role) -> set[str]:
    if role is not Role.DRIVE:
        return set([d.name for d in description.devices if d.kind == _KINDS[role]][:1])
    if (drive := description.drive) is None:
        return set()
    wheels = (drive.left, drive.right, drive.left_encoder, drive.right_encoder)
    return {name for name in wheels if name} | {sensor.name for sensor in description.range_sensors_ahead}


@dataclass(frozen=True)
class _SensorLayers:
    """What every sensor is read through."""

    clock: TickClock
    max_age: float
    latch: Latch
    conditions: Conditions
    seed: int

    def over(self, device: Device) -> Device:
        """Return a sensor or display under its layers, another device as it is."""
        if isinstance(device, Camera):
            return LayeredCamera(device, self._read(device, conditioned_camera(device, self.conditions, self.seed)))
        if isinstance(device, RangeSensor):
            return LayeredRangeSensor(device, self._read(device, conditioned_range(device, self.conditions, self.seed)))
        if isinstance(device, Encoder):
            return LayeredEncoder(device, self._read(device, device.read))
        if isinstance(device, Display):
            return LayeredDisplay(device)
        return device

    def _read(self, device: Device, read: Reader[SampleT]) -> OnceATick[SampleT]:
        return OnceATick(self.clock, Fresh(device.name, self.clock, self.max_age, self.latch, read))


def _conditioned_wheels(devices: Mapping[str, Device], drive: Drive, conditions: Conditions) -> dict[str, Device]:
    gains = {drive.left: conditions.wheel_gain_left, drive.right: conditions.wheel_gain_right}
    motors = {name: device for name, device in devices.items() if isinstance(device, Motor)}
    return {name: conditioned_motor(motors[name], gain) for name, gain in gains.items() if name in motors}
