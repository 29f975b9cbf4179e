"""The simulation: its clock, the robot's motion, and the truth about it."""

from __future__ import annotations

from functools import cached_property

from robotcore.backend import Setup
from robotcore.clock import SteppedClock
from robotcore.description import MotorDescription, WorldDescription
from robotcore.geometry import Pose, Twist

from drivers.kinematic.contact import Bumper
from drivers.kinematic.motion import Chassis, Wheel
from drivers.kinematic.painter import Painter
from drivers.kinematic.surroundings import Surroundings


class Simulation:
    """A robot in its world, moved by its own clock. It is also the run's `TruthSource`."""

    def __init__(self, setup: Setup, world: WorldDescription) -> None:
        self.world = world
        self.clock = SteppedClock(setup.rate_hz, self._advance)
        motors = setup.robot.all_of(MotorDescription)
        self.wheels = {motor.name: Wheel(motor.lag_s, self.clock.step) for motor in motors}
        self._bumper = Bumper(Surroundings(setup.robot.body.footprint, world), world.start.pose)
        self._chassis = self._make_chassis(setup, world.start.pose)
        driven = {setup.robot.drive.left, setup.robot.drive.right} if setup.robot.drive else set()
        free = [wheel for name, wheel in self.wheels.items() if name not in driven]
        self._moving = [*free, self._chassis] if self._chassis else free

    @cached_property
    def painter(self) -> Painter:
        """Paints the world for every camera; made when the first picture is read."""
        return Painter(self.world)

    @property
    def step_count(self) -> int:
        """How many physics steps have been taken."""
        return round(self.clock.now() * self.clock.steps_per_second)

    def pose(self) -> Pose:
        return self._chassis.pose if self._chassis else self.world.start.pose

    def twist(self) -> Twist:
        return self._chassis.twist if self._chassis else Twist(0.0, 0.0)

    def contacts(self) -> int:
        return self._bumper.contacts

    def _make_chassis(self, setup: Setup, start: Pose) -> Chassis | None:
        if (drive := setup.robot.drive) is None:
            return None
        left, right = self.wheels[drive.left], self.wheels[drive.right]
        return Chassis(start, drive.geometry, left, right, setup.robot.body.reach_m, self._bumper)

    def _advance(self, steps: int) -> None:
        for _ in range(steps):
            for moving in self._moving:
                moving.advance()
