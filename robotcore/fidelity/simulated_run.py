"""Repeat the commands of a recorded run in a simulator, and measure its robot at the recorded ticks."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robotcore.description import DeviceDescription, RobotDescription, WorldDescription
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.fidelity.commands import ServoCommand, WheelCommand
from robotcore.fidelity.motor_conversion import MotorConversion
from robotcore.fidelity.run_data import (
    SIDES,
    AngleSeries,
    PictureSeries,
    RangeSeries,
    RunData,
    list_ray_sensors,
    read_distances,
    unwrap,
)
from robotcore.geometry import Pose, Wheels
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Actuator, Sensor
from robotcore.hal.robot import Robot
from robotcore.hal.truth import TruthSource
from robotcore.kinds.motor import MotorDescription
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.compensation import CompensationLayer
from robotcore.runtime.layers.drive import build_output
from robotcore.runtime.layers.imperfections import ImperfectionLayer
from robotcore.safety.wheel_output import WheelOutput

ON_STEP = 1e-6
"""A time counts as that of a simulation step if it differs from it by less than this share of a step."""

NO_OPENGL = "no-opengl"
"""The kind of the error of a camera whose simulator cannot draw pictures on this machine."""


@dataclass(frozen=True)
class SimulationInputs:
    """The commands and the reads of a recorded run, and the simulated robot that repeats them."""

    recorded: RobotDescription
    """The description of the recording. The readings of its sensors were compensated with it."""
    robot: RobotDescription
    """The description of the simulated robot."""
    world: WorldDescription
    """The world, with the start of the recorded run as its start."""
    times: Sequence[float]
    """The time of each tick in seconds since the first tick."""
    wheel_commands: Sequence[WheelCommand]
    servo_commands: Sequence[ServoCommand] = ()
    conversions: Mapping[str, MotorConversion] = field(default_factory=dict)
    """The conversion of the velocities of each wheel to commands, by the name of the motor."""
    reads: Mapping[int, Sequence[str]] = field(default_factory=dict)
    """The names of the sensors to read in each tick, by the index of the tick."""
    rate_hz: float = 20.0
    seed: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)
    """The options of the backend."""

    @property
    def devices(self) -> frozenset[str]:
        """The names of the devices that the simulator opens."""
        drive = self.robot.drive
        moved = {*drive.motors, *drive.encoders, *filter(None, (drive.steering_servo,))} if drive else set()
        read = {name for names in self.reads.values() for name in names}
        carriers = {carrier for name in read for carrier in self.robot.list_carriers(name)}
        return frozenset(moved | read | carriers)


@dataclass(frozen=True, eq=False)
class SimulatedRun:
    """The measurements of a simulated run, and the cameras that the simulator could not open."""

    data: RunData
    missing: frozenset[str] = frozenset()


def simulate(backend: Backend, inputs: SimulationInputs) -> SimulatedRun:
    """Repeat the commands of a recorded run in a simulator.

    Commands take effect at their recorded times. In the simulation step within which a command changes, each motor gets
    the mean of its velocities over the step. A camera is left out if the simulator cannot draw on this machine.

    Raises DeviceError or BackendError if the simulator cannot open the robot, or fails.
    """
    cameras = {camera.name for camera in inputs.robot.all_of("camera")}
    try:
        return SimulatedRun(_simulate(backend, inputs))
    except DeviceError as error:
        failures = error.failures if isinstance(error, DeviceGroupError) else (error,)
        if not any(isinstance(each, DeviceError) and each.kind == NO_OPENGL for each in failures):
            raise
    reads = {index: [name for name in names if name not in cameras] for index, names in inputs.reads.items()}
    missing = frozenset(inputs.devices & cameras)
    return SimulatedRun(_simulate(backend, replace(inputs, reads=reads)), missing)


def _simulate(backend: Backend, inputs: SimulationInputs) -> RunData:
    # The sections of the file name real devices, and none of them is opened.
    devices = tuple(_raise_max_velocity(each, inputs.conversions.get(each.name)) for each in inputs.robot.devices)
    robot = inputs.robot.model_copy(update={"backends": {}, "devices": devices})
    setup = Setup(robot, inputs.world, inputs.devices, inputs.rate_hz, inputs.seed, options=inputs.options)
    with backend.open(setup) as opened:
        return _Simulation(opened, inputs).run()


def _raise_max_velocity(device: DeviceDescription, conversion: MotorConversion | None) -> DeviceDescription:
    """Return a device. A motor reaches the velocities of its conversion, and responds to commands as before."""
    if conversion is None or not isinstance(device, MotorDescription):
        return device
    return device.raise_max_velocity(conversion.reach)


class _BlendedMotor:
    """The output of a motor. It sends a mean of the last velocity and the new one.

    send: sends a velocity to the simulator.
    convert: converts a recorded command to the velocity of the wheel.
    """

    def __init__(self, send: Callable[[float], float], convert: Callable[[float], float]) -> None:
        self._send, self._convert = send, convert
        self._last = 0.0
        self.share = 1.0
        """The share of the new velocity, from 0 to 1."""

    def set_velocity(self, rad_s: float) -> float:
        velocity = self._convert(rad_s)
        self._send(self._last + (velocity - self._last) * self.share)
        if self.share == 1:
            self._last = velocity
        return rad_s


class _Simulation:
    """A simulated robot that repeats the commands of a recorded run."""

    def __init__(self, opened: Robot, inputs: SimulationInputs) -> None:
        self._robot, self._inputs, self._clock = opened, inputs, opened.clock
        assert opened.truth
        self._truth: TruthSource = opened.truth
        # Without steps, every time is one at which a command can change.
        self._step = self._clock.step if isinstance(self._clock, SteppedClock) else 0.0
        self._layer = ImperfectionLayer(inputs.world.conditions, inputs.seed, inputs.robot.drive)
        self._compensation = CompensationLayer(inputs.recorded)
        self._motors: list[_BlendedMotor] = []
        self._output = self._build_output()
        self._readers = {name: self._build_reader(name) for name in opened.devices}
        self._sequences: dict[str, int] = {}
        self._fields = list_ray_sensors(inputs.robot)
        self._widths = {camera.name: camera.width_px for camera in inputs.robot.all_of("camera")}
        self._angles: dict[str, list[tuple[float, float]]] = {}

    def run(self) -> RunData:
        """Repeat all commands and return the measurements."""
        data, poses = RunData(np.array(self._inputs.times), np.empty((0, 3))), []
        wheels, servos = deque(self._inputs.wheel_commands), deque(self._inputs.servo_commands)
        for index, time in enumerate(self._inputs.times):
            while wheels and wheels[0].time < time:  # a command of the tick follows its reads
                self._command(wheels.popleft())
            self._sleep(time)
            poses.append(self._measure_pose(time))
            self._measure(data, index)
            while servos and servos[0].time <= time:
                self._turn_servo(servos.popleft())
        data.poses = unwrap(poses)
        data.angles = self._collect_angles()
        data.contacts = self._truth.contacts()
        return data

    def _build_output(self) -> WheelOutput | None:
        drive = self._inputs.robot.drive
        if drive is None:
            return None
        outputs = {}
        for name, motor in self._robot.motors.items():
            layered = self._layer.motor(MotorOutput.from_motor(motor))
            blended = _BlendedMotor(layered.set_velocity, self._inputs.conversions.get(name, float))
            self._motors.append(blended)
            outputs[name] = replace(layered, set_velocity=blended.set_velocity)
        servo = self._robot.devices.get(drive.steering_servo or "")
        return build_output(drive, outputs, servo.send if isinstance(servo, Actuator) else None)

    def _build_reader(self, name: str) -> Callable[[], Any]:
        device = self._robot.devices[name]
        if not isinstance(device, Sensor):
            return lambda: None
        return self._compensation.sensor(device, self._layer.sensor(device, device.read))

    def _command(self, command: WheelCommand) -> None:
        """Send a command to the motors, in the middle of a step if the clock has steps."""
        if self._output is None:
            return
        self._sleep(command.time)
        if (late := command.time - self._clock.now()) > ON_STEP * self._step:
            self._send(command.wheels, 1 - late / self._step)
            self._clock.sleep_until(self._clock.now() + self._step)
        self._send(command.wheels, 1.0)

    def _sleep(self, time: float) -> None:
        """Sleep until the last simulation step that is not after a time."""
        steps = math.floor(time / self._step + ON_STEP) if self._step else 0
        self._clock.sleep_until(steps * self._step if self._step else time)

    def _send(self, wheels: Wheels, share: float) -> None:
        assert self._output
        for motor in self._motors:
            motor.share = share
        self._output.set_wheels(wheels)

    def _turn_servo(self, command: ServoCommand) -> None:
        servo = self._robot.devices.get(command.servo)
        if isinstance(servo, Actuator):
            servo.send(command.angle)

    def _measure_pose(self, time: float) -> Pose:
        """Return the true pose at a time, which may be up to a step after that of the clock."""
        pose, twist, passed = self._truth.pose(), self._truth.twist(), time - self._clock.now()
        return pose.advance(twist.linear * passed, twist.angular * passed)

    def _measure(self, data: RunData, index: int) -> None:
        drive = self._inputs.robot.drive
        for name in drive.encoders if drive else ():
            sample = self._readers[name]()
            self._angles.setdefault(name, []).append((sample.time, sample.angle))
        for name in self._inputs.reads.get(index, ()):
            sample = self._readers[name]()
            if self._sequences.get(name) == sample.sequence:
                continue
            self._sequences[name] = sample.sequence
            if name in self._fields:
                distances = read_distances(sample, self._fields[name])
                data.ranges.setdefault(name, RangeSeries()).add(index, distances, sample.time)
            elif name in self._widths:
                data.pictures.setdefault(name, PictureSeries(self._widths[name])).add(index, sample.image)

    def _collect_angles(self) -> dict[str, AngleSeries]:
        drive = self._inputs.robot.drive
        if drive is None or not drive.encoders:
            return {}
        series = {name: AngleSeries(*np.array(pairs).T) for name, pairs in self._angles.items()}
        names = dict(zip(SIDES, (drive.left_encoders, drive.right_encoders), strict=True))
        return {side: AngleSeries.mean([series[name] for name in encoders]) for side, encoders in names.items()}
