"""Apps that are recorded and replayed. They differ in their commands, reads and ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from robotcore.autonomy.routines import Routine, on_stop, parallel, race, wait, wait_until
from robotcore.errors import DeviceError, SafetyStop
from robotcore.geometry import Wheels
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.motor import Motor
from robotcore.optics import Image
from robotcore.runtime.behaviour import Behaviour, Status

FinalAction = Literal["succeed", "fail", "go_on", "divide", "command_nan", "swallow_nan", "rename_nan", "stop_and_go"]


@dataclass
class FinalActionApp(Behaviour):
    """Drives at ``speed``. From tick number ``ticks`` on it calls the method ``action``. Its state counts the ticks."""

    ticks: int = 5
    speed: float = 0.1
    action: FinalAction = "succeed"
    needs = frozenset({Role.DRIVE, Role.RANGE})
    count = 0

    def step(self, robot: Robot) -> Status:
        self.count += 1
        self.state = f"tick {self.count}"
        distance = robot.range.read().distance
        sent = robot.drive.set_velocity(self.speed, 0.0 if distance > 1 else 0.1)
        if sent.linear != self.speed:
            self.state += " held back"
        return getattr(self, self.action)(robot) if self.count >= self.ticks else Status.RUNNING

    def succeed(self, robot: Robot) -> Status:
        return Status.SUCCESS

    def fail(self, robot: Robot) -> Status:
        self.reason = f"at {robot.clock.now():.2f} s"
        return Status.FAILURE

    def go_on(self, robot: Robot) -> Status:
        return Status.RUNNING

    def divide(self, robot: Robot) -> Status:
        raise ZeroDivisionError(f"in tick {self.count}")

    def command_nan(self, robot: Robot) -> Status:
        robot.drive.set_wheels(math.nan, 0.0)
        return Status.RUNNING

    def swallow_nan(self, robot: Robot) -> Status:
        try:
            robot.drive.set_wheels(math.inf, 0.0)
        except SafetyStop:
            self.state = "swallowed"
        return Status.RUNNING

    def rename_nan(self, robot: Robot) -> Status:
        try:
            robot.drive.set_wheels(math.nan, 0.0)
        except SafetyStop:
            raise KeyError("renamed") from None
        return Status.RUNNING

    def stop_and_go(self, robot: Robot) -> Status:
        robot.drive.stop()
        robot.drive.set_wheels(self.count / 3, 0.0)
        if self.count % 2:
            robot.drive.stop()
        self.state += f" {robot.drive.pose.heading!r}"
        return Status.SUCCESS if self.count == 20 else Status.RUNNING


@dataclass
class SwallowingApp(FinalActionApp):
    """Catches each exception of its step, also the one that ends a replay."""

    def step(self, robot: Robot) -> Status:
        try:
            return super().step(robot)
        except Exception:  # noqa: BLE001  as an app may do
            return Status.RUNNING


@dataclass
class IntermittentApp(Behaviour):
    """Reads in every third tick and drives in every fourth, so that leases end. Devices may fail."""

    count = 0
    needs = frozenset({Role.DRIVE, Role.RANGE, Role.CAMERA})

    def step(self, robot: Robot) -> Status:
        self.count += 1
        if self.count % 3 == 0:
            try:
                self.state = f"picture {robot.camera.read().sequence}, distance {robot.range.read().distance!r}"
            except DeviceError as error:
                self.state = f"lost {error.device}"
        if self.count % 4 == 0:
            sent = robot.drive.set_wheels(*Wheels(2.0 + self.count / 7, 1.0))
            self.state += f" {sent.left!r}"
        return Status.SUCCESS if self.count == 40 else Status.RUNNING


@dataclass
class GripperApp(Behaviour):
    """Moves a gripper outside the drive at ``speed``, depending on its answers."""

    action: FinalAction = "succeed"
    speed: float = 1.5
    needs = frozenset({Role.DRIVE})
    count = 0

    def step(self, robot: Robot) -> Status:
        self.count += 1
        gripper = robot["gripper"]
        assert isinstance(gripper, Motor)
        robot.drive.set_wheels(1.0, 1.0)
        try:
            self.state = f"at {gripper.set_velocity(self.speed * self.count)!r}"
        except DeviceError as error:
            self.state = str(error)
        if self.count % 3 == 0:
            gripper.stop()
        if self.count == 12 and self.action == "command_nan":
            gripper.set_velocity(math.nan)
        return Status.SUCCESS if self.count == 12 else Status.RUNNING


class DriveThenReadApp(Behaviour):
    """Drives, then reads the sensor that the range guard has read before."""

    needs = frozenset({Role.DRIVE, Role.RANGE})
    count = 0

    def step(self, robot: Robot) -> Status:
        self.count += 1
        self.state = "drives"
        try:
            robot.drive.set_wheels(1.0, 1.0)
        except DeviceError as error:
            self.state = str(error)
        self.state += f" {robot.range.read().distance!r}"
        return Status.SUCCESS if self.count == 12 else Status.RUNNING


class DisplayApp(Behaviour):
    """Shows each picture of the camera twice, and raises an error with an address of an object."""

    needs = frozenset({Role.CAMERA, Role.DISPLAY})
    count = 0

    def step(self, robot: Robot) -> Status:
        self.count += 1
        if self.count == 13:
            raise RuntimeError(f"seen enough: {object()!r}")
        image = robot.camera.read().image
        self.state = " ".join(self._show(robot, image) for _ in range(2))
        return Status.RUNNING

    def _show(self, robot: Robot, image: Image) -> str:
        try:
            robot.display.show(image)
        except DeviceError as error:
            return str(error)
        return "shown"


class Weave(Behaviour):
    """Weaves, drives backward, asks for a turn on the spot, and stops."""

    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        now = robot.clock.now()
        self.state = f"{robot.drive.pose.heading:.3f}"
        if now < 2.0:
            robot.drive.set_velocity(0.2 if now < 1.0 else -0.2, 1.5 * math.sin(3 * now))
        elif now < 2.5:
            robot.drive.set_velocity(0.0, 1.0)
        else:
            robot.drive.stop()
        return Status.SUCCESS if now > 2.8 else Status.RUNNING


@dataclass
class BangBang(Behaviour):
    """Turns its wheels to and fro. Its state has the pose, which it reads ``reads`` times in a tick."""

    reads: int = 1
    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        now = robot.clock.now()
        self.state = " ".join(repr(tuple(robot.drive.pose)) for _ in range(self.reads))
        robot.drive.set_wheels(*[(12.0, 0.0), (12.0, 12.0), (0.0, 12.0), (-12.0, 0.0)][int(5 * now) % 4])
        return Status.SUCCESS if now > 2.0 else Status.RUNNING


class RoutineApp(Behaviour):
    """Turns to the left while its range sensor measures, and drives for two seconds. It commands zero at its end."""

    needs = frozenset({Role.DRIVE, Role.RANGE})

    def run(self, robot: Robot) -> Routine[Status]:
        yield from on_stop(self._drive(robot), lambda: robot.drive.set_velocity(0.0, 0.0))
        return Status.SUCCESS

    def _drive(self, robot: Robot) -> Routine[None]:
        for number in range(4):
            self.state = f"round {number}"
            near = wait_until(lambda: robot.range.read().distance < 0.5)
            yield from race(self._keep_velocity(robot, 0.0, 0.5), wait(robot, 0.5), near)
            echo = wait_until(lambda: robot.range.read().distance > 0.1)
            yield from race(self._keep_velocity(robot, 0.2, 0.0), parallel(wait(robot, 0.5), echo))

    def _keep_velocity(self, robot: Robot, linear: float, angular: float) -> Routine[None]:
        while True:
            robot.drive.set_velocity(linear, angular)
            yield
