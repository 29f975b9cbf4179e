"""Assembles the robot of a run: the driver's devices, the layers, the safety stage, and the devices of the app."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial, reduce
from typing import Any

from robotcore.description import Conditions, Mount, RobotDescription
from robotcore.errors import DeviceLostError, UsageError
from robotcore.geometry import Pose
from robotcore.hal.clock import AppClock, TickClock
from robotcore.hal.device import Actuator, Device, Sensor
from robotcore.hal.joint import Joint, Joints
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.display import Display
from robotcore.kinds.motor import Motor, MotorDescription, invalid_velocity
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader, Send, Tap
from robotcore.runtime.layers.checks import CallMonitorLayer, MaxAgeLayer
from robotcore.runtime.layers.compensation import CompensationLayer
from robotcore.runtime.layers.devices import AppMotor, wrap_actuator, wrap_sensor
from robotcore.runtime.layers.drive import build_drive, build_output
from robotcore.runtime.layers.encoder_polling import EncoderPolling, build_polling
from robotcore.runtime.layers.guardian import GuardianLayer
from robotcore.runtime.layers.imperfections import PERFECT, ImperfectionLayer
from robotcore.runtime.layers.standalone_motor import StandaloneGuard
from robotcore.runtime.layers.timing import TickTimer
from robotcore.safety.command_filter import CommandFilter
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.thread_reserve import Reserve
from robotcore.safety.watchdog import ActivityMonitor


@dataclass(frozen=True)
class AssembledRobot:
    """The app's robot, with the clock, the latch, the command filter and the motor stops of its run."""

    robot: Robot
    """The robot with the app's devices."""
    clock: TickClock
    """The clock of the loop."""
    latch: Latch
    """The latch of the run. A tripped latch ends the run."""
    command_filter: CommandFilter | None
    """The filter of the drive's commands. None if the run has no drive."""
    motor_stops: StopGroup
    """Stops all motors."""
    activity: ActivityMonitor
    """The activity of the loop's thread, for the watchdog."""
    suspend_functions: tuple[Callable[[str], None], ...] = ()
    """The functions that stop the drive and each other motor between two ticks. Their argument is the cause."""
    taps: tuple[Tap, ...] = ()
    """The taps, which record or compare the calls of the app."""
    timer: TickTimer | None = None
    """Measures the phases of each tick."""
    polling: EncoderPolling | None = None
    """The polls of the drive's encoders between the ticks. None if there are none."""

    def suspend(self, cause: str) -> None:
        """Stop every motor between two ticks, for example before the program is suspended.

        cause: the cause of the intervention in the trace.

        A DeviceLostError of a stop is ignored. Any other exception is raised after all stops were tried.
        """
        with ExitStack() as each:
            for suspend in self.suspend_functions:
                each.callback(_suspend_quietly, suspend, cause)


def assemble(
    raw: Robot,
    description: RobotDescription,
    rate_hz: float,
    conditions: Conditions = PERFECT,
    seed: int = 0,
    faults: Sequence[Layer] = (),
    taps: Sequence[Tap] = (),
    guard: GuardianLayer | None = None,
    activity: ActivityMonitor | None = None,
    reserve: Reserve | None = None,
    timer: TickTimer | None = None,
    encoder_rate_hz: float | None = None,
) -> AssembledRobot:
    """Build the app's robot from the robot that a backend opened.

    raw: the robot that the backend opened.
    description: the robot's description, with its safety limits.
    rate_hz: the number of ticks in a second.
    conditions: the imperfections of the world.
    seed: the seed of the noise in ``conditions``.
    faults: the layers of injected faults.
    taps: the recorder and the replay. They read each sensor once in a tick, and get the app's unchanged commands.
    guard: the layer that reports motor commands to the guardian process.
    activity: the record of the loop thread's activity for the watchdog.
    reserve: the reserved threads and memory for stops.
    timer: measures the phases of each tick.
    encoder_rate_hz: the number of reads of the drive's encoders in a second; None for one read a tick. In real time,
        they begin with `EncoderPolling.begin`.
    """
    reserve = reserve or Reserve(MonotonicClock())
    safety, activity, latch = description.safety, activity or ActivityMonitor(), Latch(reserve)
    for tap in taps:
        tap.latch(latch)
    watched = CallMonitorLayer(activity, safety.answer_s, raw.name)
    polling = build_polling(raw.devices, description.drive, raw.clock, encoder_rate_hz, rate_hz)
    clock = raw.clock
    for layer in (*([polling] if polling else []), watched, *faults):
        clock = layer.clock(clock)
    ticks = TickClock(clock)
    # This tuple is the order of all layers, from the driver up to the app. The safety stage lies between the
    # layers' motor outputs and the taps' command hooks.
    layers: tuple[Layer, ...] = (
        *([polling] if polling else []),
        watched,
        *([guard] if guard else []),
        ImperfectionLayer(conditions, seed, description.drive),
        *faults,
        CompensationLayer(description),
        *taps,
        MaxAgeLayer(ticks, safety.max_age_s, safety.watchdog_s, latch),
        *([timer] if timer else []),
    )
    taps = [layer for layer in layers if isinstance(layer, Tap)]
    motors = {
        name: reduce(lambda output, layer: layer.motor(output), layers, MotorOutput.from_motor(motor))
        for name, motor in raw.motors.items()
    }
    joints = Joints(description, ticks)
    devices = {device.name: _wrap_device(device, ticks, layers, joints, latch) for device in raw.devices.values()}
    _set_properties(devices, description, joints)
    reach = {name: motor.max_velocity for name, motor in raw.motors.items()}
    for described in description.all_of(MotorDescription):
        reach[described.name] = min(described.max_wheel_velocity_rad_s, reach.get(described.name, math.inf))
    motor_stops = StopGroup.create(*motors.values(), reserve=reserve)
    latch.add_stop(motor_stops.apply_apart)
    drive, guarded = description.drive, None
    suspend_functions: list[Callable[[str], None]] = []
    servo = drive.steering_servo if drive else None
    if drive and {*drive.motors, servo} <= {*motors, *raw.devices, None}:
        steer = _take_servo(servo, raw, devices, layers, joints) if servo else None
        guarded = build_drive(
            devices,
            build_output(drive, motors, steer),
            min(reach[name] for name in drive.motors),
            description,
            drive,
            ticks,
            latch,
            rate_hz,
            taps,
            motor_stops,
            joints,
            guard.take_stops if guard else lambda: 0,
            timer,
            polling,
        )
        suspend_functions.append(guarded.suspend)
    for name, motor in raw.motors.items():
        if guarded and drive and name in drive.motors:
            output = MotorOutput(name, partial(_refuse_command, name, latch), guarded.command_filter.stop)
        else:
            lease = safety.lease_ticks / rate_hz
            stops = motor_stops.select(motors[name])
            lone = StandaloneGuard(motors[name], reach[name], ticks, lease, latch, stops)
            output = reduce(lambda output, tap: tap.standalone_motor(output), taps, lone.output)
            output = timer.standalone_motor(output) if timer else output
            suspend_functions.append(lone.suspend)
        devices[name] = AppMotor(motor, output)
    robot = Robot(
        raw.name, AppClock(ticks), devices.values(), drive=guarded.drive if guarded else None, release=raw.close
    )
    command_filter = guarded.command_filter if guarded else None
    return AssembledRobot(
        robot,
        ticks,
        latch,
        command_filter,
        motor_stops,
        activity,
        tuple(suspend_functions),
        tuple(taps),
        timer,
        polling,
    )


def _wrap_device(device: Device, clock: TickClock, layers: Sequence[Layer], joints: Joints, latch: Latch) -> Device:
    """Return the app's version of a driver's sensor or actuator. Its calls pass through the layers.

    joints: the assumed motion of the servos. It follows the app's commands to them.
    latch: the latch of the run. If it has tripped, an actuator other than a display refuses commands.
    """
    if isinstance(device, Sensor):
        sensor: Sensor[Any] = device
        read: Reader[Any] = reduce(lambda read, layer: layer.sensor(sensor, read), layers, sensor.read)
        return wrap_sensor(sensor, clock, read)
    if isinstance(device, Actuator) and not isinstance(device, Motor):
        actuator: Actuator[Any] = device
        send: Send = actuator.send
        for layer in layers:
            send = layer.actuator(actuator, send)
        if device.name in joints:
            send = _follow(joints[device.name], send)
        return wrap_actuator(actuator, send, None if isinstance(device, Display) else latch)
    return device


def _take_servo(name: str, raw: Robot, devices: dict[str, Device], layers: Sequence[Layer], joints: Joints) -> Send:
    """Return the function that sends the angle of the servo that steers. The app's servo then refuses commands.

    The taps get the commands to the drive instead of those to the servo.
    """
    servo = raw.devices[name]
    assert isinstance(servo, Actuator), f"{name} is no actuator"
    send: Send = servo.send
    for layer in layers:
        if not isinstance(layer, Tap):
            send = layer.actuator(servo, send)
    shown: Any = wrap_actuator(servo, partial(_refuse_angle, name), None)
    devices[name], follow = shown, _follow(joints[name], send)

    def send_angle(angle: float) -> float:
        shown.angle = follow(angle)
        return float(shown.angle)

    return send_angle


def _refuse_angle(servo: str, _angle: float) -> float:
    raise UsageError(
        f"{servo} steers the drive. Command the drive: robot.drive.set_velocity(linear, angular)",
        kind="servo-of-the-drive",
        device=servo,
    )


def _follow(joint: Joint, send: Send) -> Send:
    """Return a function that sends a command to a servo, and turns its joint to the angle that was sent."""

    def send_angle(angle: float) -> float:
        sent: float = send(angle)
        joint.turn_to(sent)
        return sent

    return send_angle


def _refuse_command(wheel: str, latch: Latch, rad_s: float) -> float:
    if not math.isfinite(rad_s):
        latch.trip(invalid_velocity(wheel, rad_s))
    raise UsageError(
        f"{wheel} is a wheel of the drive. Command both wheels: robot.drive.set_wheels(left, right)",
        kind="wheel-of-the-drive",
        device=wheel,
    )


def _suspend_quietly(suspend: Callable[[str], None], cause: str) -> None:
    with suppress(DeviceLostError):
        suspend(cause)


def _set_properties(devices: Mapping[str, Device], description: RobotDescription, joints: Joints) -> None:
    mounts = description.mounts
    for each in description.devices:
        if device := devices.get(each.name):
            device._attempt(each.configure, device)  # noqa: SLF001  the kind may be of another package
            if (mount := mounts.get(each.name)) and mount.on:
                device.mount = partial(_locate_pose, joints, mount)


def _locate_pose(joints: Joints, mount: Mount) -> Pose:
    return joints.locate(mount).pose
