"""The excitation of a robot, for its identification: commands by a plan, and the samples of the sensors."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from robotcore.autonomy.routines import Routine
from robotcore.calibration.least_squares import Array
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.robot import Robot, Role
from robotcore.hal.truth import Truth
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.imu import Imu
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")

ROUNDING_S = 1e-6
"""A step has ended if less than this time is left, in seconds, because ticks add rounding errors."""


class ExcitationStep(NamedTuple):
    """A time during which both commands stay the same."""

    duration_s: float
    left: float = 0.0
    """The share of the full command of the left wheels, from -1 to 1."""
    right: float = 0.0
    """The share of the full command of the right wheels, from -1 to 1."""


class CommandStep(NamedTuple):
    """A time during which a motor's command did not change."""

    start: float
    """The time of the first command, in seconds."""
    end: float
    command: float
    """The share of the full command, from -1 to 1. It is a duty for a motor with a model."""


class ExcitationLog:
    """The commands and the samples of an excitation."""

    def __init__(self) -> None:
        self._steps: list[tuple[float, ExcitationStep]] = []
        self._sent: list[tuple[float, Wheels]] = []
        self._samples: dict[str, list[tuple[float, float]]] = defaultdict(list)
        self._end = 0.0

    def begin(self, time: float, step: ExcitationStep) -> None:
        """Add a step that begins at a time in seconds."""
        self._steps.append((time, step))

    def add(self, device: str, time: float, value: float) -> None:
        """Add a sample, unless its time is that of the last one.

        time: the time of the sample, in seconds.
        value: an angle in radians, or a distance in metres.
        """
        series = self._samples[device]
        if not series or time > series[-1][0]:
            series.append((time, value))

    def add_sent(self, time: float, velocities: Wheels) -> None:
        """Add the velocities that were sent at a time in seconds, after all limits, in rad/s."""
        self._sent.append((time, velocities))

    def finish(self, time: float) -> None:
        """End the last step at a time in seconds."""
        self._end = time

    def list_steps(self, side: Side) -> list[CommandStep]:
        """Return the steps of one side. Steps with the same command in a row are one step."""
        merged: list[CommandStep] = []
        for (start, step), end in zip(self._steps, self.edges[1:], strict=True):
            command = step.left if side == "left" else step.right
            if merged and merged[-1].command == command:
                merged[-1] = merged[-1]._replace(end=end)
            else:
                merged.append(CommandStep(start, end, command))
        return merged

    def read_series(self, device: str) -> tuple[Array, Array]:
        """Return the times and the values of a device, each (samples,): angles in radians, or distances in metres."""
        series = np.array(self._samples[device]).reshape(-1, 2)
        return series[:, 0], series[:, 1]

    def integrate_sent(self, side: Side, lag_s: float = 0.0) -> tuple[Array, Array]:
        """Return the times, and the angles by which the sent velocities turn a wheel, each (ticks,), in s and rad.

        lag_s: the time constant with which the wheel follows a step of its command, in seconds.
        """
        times = np.array([time for time, _ in self._sent])
        velocities = np.array([sent.left if side == "left" else sent.right for _, sent in self._sent])
        durations = np.diff(times, append=self._end)
        reached = [0.0]
        for duration, velocity in zip(durations, velocities, strict=True):
            remaining = math.exp(-duration / lag_s) if lag_s else 0.0
            reached.append(float(velocity + (reached[-1] - velocity) * remaining))
        turned = np.append(0.0, np.cumsum(durations * velocities)) - lag_s * np.array(reached)
        return np.append(times, self._end), turned

    @property
    def edges(self) -> list[float]:
        """The time at which each step begins, and the time at which the last one ends, in seconds."""
        return [*(start for start, _ in self._steps), self._end]

    def measure_turns(self, device: str) -> list[float]:
        """Return the angle by which a device has turned in each step, until the next step begins, in radians."""
        return [float(each) for each in np.diff(np.interp(self.edges, *self.read_series(device)))]


class Excitation(Behaviour):
    """Sends the commands of a plan, and logs the samples of the encoders, the IMU and the range sensors in each tick.

    A heading counts whole turns. The robot stands before the first step and after the last one.

    steps: the plan.
    full_rad_s: the velocity that is sent for the full command, in rad/s.
    """

    needs = frozenset({Role.DRIVE})
    wants = frozenset({Encoder, Imu, RangeSensor})

    def __init__(self, steps: Sequence[ExcitationStep], full_rad_s: float) -> None:
        self.steps, self.full_rad_s, self.log = steps, full_rad_s, ExcitationLog()
        self._heading = 0.0
        self._last_heading: dict[str, float] = {}

    @property
    def duration_s(self) -> float:
        """The duration of the plan, in seconds."""
        return sum(step.duration_s for step in self.steps)

    def run(self, robot: Robot) -> Routine[Status]:
        for step in self.steps:
            start = robot.clock.now()
            self.log.begin(start, step)
            while robot.clock.now() < start + step.duration_s - ROUNDING_S:
                sent = robot.drive.set_wheels(step.left * self.full_rad_s, step.right * self.full_rad_s)
                self.log.add_sent(robot.clock.now(), sent)
                self._read(robot)
                yield
        robot.drive.stop()
        self._read(robot)
        self.log.finish(robot.clock.now())
        return Status.SUCCESS

    def _read(self, robot: Robot) -> None:
        for encoder in robot.all(Encoder):
            angle = encoder.read()
            self.log.add(encoder.name, angle.time, angle.angle)
        for imu in robot.all(Imu):
            sample = imu.read()
            last = self._last_heading.get(imu.name, sample.heading)
            turned = wrap_angle(sample.heading - last)
            self._last_heading[imu.name] = last + turned
            self.log.add(imu.name, sample.time, last + turned)
        for sensor in robot.all(RangeSensor):
            echo = sensor.read()
            self.log.add(sensor.name, echo.time, echo.distance)


class TruePoseObserver:
    """An observer that stores the true poses at the start and at the end of a run on a simulator."""

    def __init__(self) -> None:
        self.start: Pose | None = None
        self.end_pose: Pose | None = None
        self.turned = 0.0
        """The true angle by which the robot has turned, with whole turns, in radians."""
        self._truth: Truth | None = None

    def begin(self, run: RunContext) -> None:
        self._truth = run.truth
        if self._truth:
            self.start = self.end_pose = self._truth.pose

    def tick(self, record: TickRecord) -> None:
        if self._truth and self.end_pose:
            pose = self._truth.pose
            self.turned += wrap_angle(pose.heading - self.end_pose.heading)
            self.end_pose = pose

    def end(self, result: RunResult) -> None:
        """Do nothing: the robot is closed."""

    @property
    def displacement(self) -> tuple[float, float] | None:
        """How far the robot has moved forward and to the left, seen from its first pose, in metres; None on a robot."""
        if self.start is None or self.end_pose is None:
            return None
        return self.start.to_local(self.end_pose.x, self.end_pose.y)
