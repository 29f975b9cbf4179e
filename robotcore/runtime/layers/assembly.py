"""Layers one over the other, over whatever device there is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import reduce
from typing import Any

from robotcore.description import (
    BatteryDescription,
    CameraDescription,
    Conditions,
    RangeSensorDescription,
    RobotDescription,
)
from robotcore.errors import DeviceLostError, UnknownNameError, UnmetNeedError
from robotcore.geometry import Pose
from robotcore.hal.clock import AppClock, Clock, TickClock
from robotcore.hal.devices import Battery, Camera, Device, Display, Encoder, Motor, RangeSensor, SampleT, Sensor
from robotcore.hal.robot import Robot, Role
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.layers.base import Layer, Reader, TickCache
from robotcore.runtime.layers.checks import CallMonitorLayer, MaxAgeLayer
from robotcore.runtime.layers.devices import (
    LayeredBattery,
    LayeredCamera,
    LayeredDisplay,
    LayeredEncoder,
    LayeredRangeSensor,
)
from robotcore.runtime.layers.drive import GuardedDrive
from robotcore.runtime.layers.imperfections import PERFECT, ImperfectionLayer
from robotcore.runtime.layers.standalone_motor import StandaloneMotor
from robotcore.safety import ActivityMonitor, CommandFilter, Latch, StopGroup
from robotcore.safety.reserve import Reserve


@dataclass(frozen=True)
class Stack:
    """The layers over every device, the lowest first; above them a sensor is read once a tick."""

    clock: TickClock
    layers: tuple[Layer, ...]

    def over(self, device: Device) -> Device:
        """Return a device under the layers."""
        match device:
            case Sensor():
                return self._over_sensor(device)
            case Motor():
                return reduce(lambda motor, layer: layer.motor(motor), self.layers, device)
            case Display():
                return LayeredDisplay(reduce(lambda display, layer: layer.display(display), self.layers, device))
        return device

    def _over_sensor(self, sensor: Sensor[Any]) -> Device:
        match sensor:
            case Camera() as camera:
                return LayeredCamera(camera, self._read(camera.read, lambda layer, read: layer.camera(camera, read)))
            case RangeSensor() as ear:
                return LayeredRangeSensor(ear, self._read(ear.read, lambda layer, read: layer.range_sensor(ear, read)))
            case Encoder() as wheel:
                return LayeredEncoder(wheel, self._read(wheel.read, lambda layer, read: layer.encoder(wheel, read)))
            case Battery() as cell:
                return LayeredBattery(cell, self._read(cell.read, lambda layer, read: layer.battery(cell, read)))
        return sensor

    def wrap_standalone(self, motor: Motor) -> Motor:
        """Return a motor that belongs to no drive under what the layers put over its guard."""
        return reduce(lambda motor, layer: layer.standalone_motor(motor), self.layers, motor)

    def _read(
        self, read: Reader[SampleT], through: Callable[[Layer, Reader[SampleT]], Reader[SampleT]]
    ) -> TickCache[SampleT]:
        for layer in self.layers:
            read = through(layer, read)
        return TickCache(self.clock, read)


def wrap_clock(clock: Clock, layers: Iterable[Layer]) -> Clock:
    """Return the clock as a loop under the layers is to sleep by it."""
    return reduce(lambda slept, layer: layer.clock(slept), layers, clock)


_KINDS = {Role.CAMERA: "camera", Role.RANGE: "range_sensor", Role.DISPLAY: "display"}
_UNGUARDED = Layer()
_MOUNTED = (CameraDescription, RangeSensorDescription)


@dataclass(frozen=True)
class Assembled:
    """A robot as an app gets it, and what its run needs besides.

    The clock that its loop ticks, the latch that ends its run, its drive's stage, the brakes on every motor, and what a
    watchdog looks at. ``halts`` stop the drive and each lone motor between two ticks, for a cause.
    """

    robot: Robot
    clock: TickClock
    latch: Latch
    stage: CommandFilter | None
    brakes: StopGroup
    where: ActivityMonitor
    halts: tuple[Callable[[str], None], ...] = ()

    def halt(self, cause: str) -> None:
        """Stop what moves between two ticks, for a cause that is no command of the app's.

        Every motor is tried. One that is lost does not hear it; raises what else is wrong.
        """
        with ExitStack() as each:
            for halt in self.halts:
                each.callback(_suspend_quietly, halt, cause)


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
    faults: Sequence[Layer] = (),
    taps: Sequence[Layer] = (),
    guard: Layer = _UNGUARDED,
    where: ActivityMonitor | None = None,
    reserve: Reserve | None = None,
) -> Assembled:
    """Put every layer over a robot that a backend opened; ``clock`` stands in for the backend's own.

    The noise of the ``conditions`` belongs to the ``seed``. ``faults`` lie right above them; above these, ``taps`` see
    each sample once, and each command as the app gives it. ``guard``, below them all, sees what motors are told.
    ``where`` learns where the program is. ``reserve`` has threads and memory for stops.
    """
    reserve = reserve or Reserve(MonotonicClock())
    safety, where, latch = description.safety, where or ActivityMonitor(), Latch(reserve)
    for tap in taps:
        tap.latch(latch)
    watched = CallMonitorLayer(where, safety.answer_s, raw.name)
    ticks = TickClock(wrap_clock(clock or raw.clock, (watched, *faults)))
    conditioned = ImperfectionLayer(conditions, seed, description.drive)
    stack = Stack(ticks, (watched, guard, conditioned, *faults, *taps, MaxAgeLayer(ticks, safety.max_age_s, latch)))
    devices = {device.name: stack.over(device) for device in raw.devices.values()}
    _mount(devices, description)
    _limit(devices, description)
    motors = {name: device for name, device in devices.items() if isinstance(device, Motor)}
    brakes = StopGroup.on(*motors.values(), reserve=reserve)
    latch.call(brakes.apply_apart)
    guarded = None
    drive = description.drive
    if drive and drive.left in motors and drive.right in motors:
        guarded = GuardedDrive.over(devices, description, drive, ticks, latch, rate_hz, stack.layers, brakes)
        devices |= guarded.motors
    alone = [motor for name, motor in motors.items() if guarded is None or name not in guarded.motors]
    lease = safety.lease_ticks / rate_hz
    lone = [StandaloneMotor(motor, ticks, lease, latch, brakes.of(motor)) for motor in alone]
    devices |= {motor.name: stack.wrap_standalone(motor) for motor in lone}
    app_clock = AppClock(ticks)
    robot = Robot(raw.name, app_clock, devices.values(), drive=guarded.drive if guarded else None, release=raw.close)
    halts = (*([guarded.suspend] if guarded else []), *(motor.suspend for motor in lone))
    return Assembled(robot, ticks, latch, guarded.stage if guarded else None, brakes, where, halts)


def _suspend_quietly(halt: Callable[[str], None], cause: str) -> None:
    with suppress(DeviceLostError):
        halt(cause)


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


def _mount(devices: Mapping[str, Device], description: RobotDescription) -> None:
    """Tell cameras and range sensors where they sit."""
    for sensor in description.devices:
        device = devices.get(sensor.name)
        if isinstance(sensor, _MOUNTED) and isinstance(device, (Camera, RangeSensor)):
            device.mount = Pose(sensor.mount.x_m, sensor.mount.y_m, sensor.mount.yaw_rad)


def _limit(devices: Mapping[str, Device], description: RobotDescription) -> None:
    """Tell batteries below which voltage they are to be charged."""
    for battery in description.all_of(BatteryDescription):
        device = devices.get(battery.name)
        if isinstance(device, Battery):
            device.warn_below = battery.warn_below_v
