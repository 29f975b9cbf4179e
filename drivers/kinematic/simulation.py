"""The simulation of a robot in a world: its clock, its motion and its ground truth."""

from __future__ import annotations

import math
from functools import cached_property

from drivers.kinematic.clearance import Clearance, CollisionChecker
from drivers.kinematic.devices import Array, WorldSlice
from drivers.kinematic.motion import Chassis, SideWheels, SteeredChassis, Wheel
from robotcore.description import AckermannDrive, Drive, SkidDrive, WorldDescription
from robotcore.geometry import Pose, Twist, wrap_angle
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.simulation_state import SimulationState
from robotcore.kinds.motor import MotorDescription
from robotcore.simulation.painter import Painter


class Simulation:
    """A robot in a world, which advances with ``clock``. It is the `TruthSource` of the run."""

    def __init__(self, setup: Setup, world: WorldDescription) -> None:
        self._robot = robot = setup.robot
        self._seed = setup.seed
        self.world = world
        self._slices: dict[float, WorldSlice] = {}
        self.clock = SteppedClock(setup.rate_hz, self._advance)
        self.wheels = {motor.name: Wheel(motor.lag_s, self.clock.step) for motor in robot.all_of(MotorDescription)}
        """The wheel of each motor, by the name of the motor."""
        self.encoded_wheels: dict[str, Wheel] = {}
        """The wheel of each encoder, by the name of the encoder."""
        self._start = world.start.pose
        self._collisions = CollisionChecker(Clearance(robot.body.footprint, world), self._start)
        self._chassis = self._build_chassis(robot.drive) if robot.drive else None
        driven = robot.drive.motors if robot.drive else ()
        self._moving: list[Wheel | Chassis] = [wheel for name, wheel in self.wheels.items() if name not in driven]
        if self._chassis:
            self._moving.append(self._chassis)

    @cached_property
    def painter(self) -> Painter:
        """The painter of the pictures of all cameras. It is created when a camera is first read."""
        return Painter(self.world)

    @property
    def body_pose(self) -> Pose:
        """The pose of the body, whose heading counts whole turns."""
        return self._chassis.pose if self._chassis else self._start

    def pose(self) -> Pose:
        x, y, heading = self.body_pose
        return Pose(x, y, wrap_angle(heading))

    def twist(self) -> Twist:
        return self._chassis.twist if self._chassis else Twist(0.0, 0.0)

    def contacts(self) -> int:
        return self._collisions.contacts

    @cached_property
    def simulation_state(self) -> SimulationState:
        """The state from which kinds of devices are simulated."""
        return SimulationState(
            self._robot,
            self.world,
            self.clock,
            self.pose,
            self.twist,
            self._cast,
            self._list_touched,
            self._seed,
            self._measure_wheel_angles,
        )

    def _cast(self, origin: Array, directions: Array, _reach_m: float) -> Array:
        pose, z = self.body_pose, float(origin[2])
        x, y = pose.to_world(float(origin[0]), float(origin[1]))
        cos, sin = math.cos(pose.heading), math.sin(pose.heading)
        dx, dy = directions[:, 0], directions[:, 1]
        if z not in self._slices:
            self._slices[z] = WorldSlice(self.world, z)
        return self._slices[z].cast(x, y, cos * dx - sin * dy, sin * dx + cos * dy)

    def _measure_wheel_angles(self) -> dict[str, float]:
        return {name: self.wheels[name].angle for name in (self._robot.drive.motors if self._robot.drive else ())}

    def _list_touched(self) -> list[str]:
        bodies = (*self.world.prisms, *self.world.targets)
        return [bodies[index].name for index in self._collisions.touched]

    def _build_chassis(self, drive: Drive) -> Chassis:
        self.encoded_wheels = {name: self.wheels[drive.motor_by_device[name]] for name in drive.encoders}
        left, right = ([self.wheels[name] for name in names] for names in (drive.left_motors, drive.right_motors))
        if isinstance(drive, AckermannDrive):
            joint, ratio = self.simulation_state.joints[drive.steering], drive.track_m / 2 / drive.wheelbase_m
            return SteeredChassis(
                self._start, drive.geometry, left[0], right[0], self._collisions, joint, ratio, self.clock
            )
        if isinstance(drive, SkidDrive):
            return Chassis(self._start, drive.geometry, SideWheels(left), SideWheels(right), self._collisions)
        return Chassis(self._start, drive.geometry, left[0], right[0], self._collisions)

    def _advance(self, steps: int) -> None:
        for _ in range(steps):
            for moving in self._moving:
                moving.advance()
