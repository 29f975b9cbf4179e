"""Where a driver is tried: how its robot is opened, what it lacks, and what all rules measure with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from functools import cache
from typing import Any, ClassVar, NamedTuple, NoReturn

import pytest

from robotcore.description import Drive, RobotDescription, WorldDescription, load_robot
from robotcore.errors import UnmetNeedError
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.devices import Encoder, Motor, Sensor
from robotcore.hal.drive import Odometry
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.layers import needed_devices
from robotcore.testing import worlds
from robotcore.testing.fakes import Gate

RATE_HZ = 20.0
SETTLING_S = 0.5
"""By then wheels turn as they were told."""


class TestSupport(str, Enum):
    """A part of the tests that a backend may lack, besides its own capabilities."""

    __test__ = False  # its name begins as those of test classes do

    WORLD = "show the world it is given"
    MOTION = "move as its motors are told"
    REPRODUCIBLE = "run twice alike"
    LOST_ECHO = "lose an echo"
    SLOW_HARDWARE = "wait for hardware"


class Motion(NamedTuple):
    """How the robot moved, in the frame it began in: metres, radians, left positive."""

    forward: float
    left: float
    turn: float


class Bench:
    """What an author fills in: ``backend``, and where they differ, the rest.

    ``robot`` is the name or the file of the description to open, ``options`` are the backend's, and ``lacks`` says
    for each capability that is missing why: its rules are skipped with that reason.
    """

    backend: ClassVar[type[Backend]]
    robot: ClassVar[str] = "rover"
    options: ClassVar[Mapping[str, Any]] = {}
    lacks: ClassVar[Mapping[TestSupport, str]] = {}

    def open(self, setup: Setup) -> Robot:
        """Open the robot, bare of every layer."""
        return self.backend().open(setup)

    def lose_echoes(self, robot: Robot) -> None:
        """From now on, let nothing come back to the range sensor of an open robot."""
        self._skip_without_hook(TestSupport.LOST_ECHO, "lose_echoes")

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        """Open the robot on fake hardware whose every answer passes ``gate``."""
        self._skip_without_hook(TestSupport.SLOW_HARDWARE, "open_gated")

    @pytest.fixture(autouse=True)
    def _installed(self) -> None:
        backend = self.backend()
        if not backend.is_installed:
            pytest.skip(f"{backend.name} is not installed: {backend.remedy}")

    @property
    def description(self) -> RobotDescription:
        """The robot that is opened."""
        return _described(self.robot)

    @property
    def openable(self) -> frozenset[str]:
        """The names of the devices that the backend can open."""
        return self.backend().openable(self.description, self.options)

    @property
    def drive(self) -> Drive:
        """The description of its drive."""
        return self.description.drive or pytest.skip(f"{self.description.name} has no drive")

    def setup_for(self, world: WorldDescription | None = None, devices: Iterable[str] | None = None) -> Setup:
        """Return what a backend is told: open ground and every device that it can open, or what else is named."""
        names = self.openable if devices is None else devices
        return Setup(self.description, world or worlds.empty(), frozenset(names), RATE_HZ, options=self.options)

    def opened(self, world: WorldDescription | None = None, *roles: Role) -> Robot:
        """Open the robot with what fills these roles; with every device, where none is named."""
        try:
            devices = needed_devices(self.description, roles) if roles else None
        except UnmetNeedError as unmet:
            pytest.skip(str(unmet))
        return self.open(self.setup_for(world, devices))

    def require(self, *needed: TestSupport | Capability) -> None:
        """Skip the rule, with the reason, where the backend lacks something."""
        for what in needed:
            if isinstance(what, TestSupport) and what in self.lacks:
                pytest.skip(f"it cannot {what.value}: {self.lacks[what]}")
            if isinstance(what, Capability) and what not in self.backend.capabilities:
                pytest.skip(f"the backend does not have the capability {what.value}")

    def motors(self, robot: Robot) -> tuple[Motor, Motor]:
        """Return the left and the right motor of the drive."""
        left, right = robot[self.drive.left], robot[self.drive.right]
        assert isinstance(left, Motor), f"{left.name} is a {type(left).__name__}, not a Motor"
        assert isinstance(right, Motor), f"{right.name} is a {type(right).__name__}, not a Motor"
        return left, right

    def encoders(self, robot: Robot) -> tuple[Encoder, Encoder]:
        """Return the left and the right encoder of the drive; skip where there are none."""
        names = self.drive.left_encoder or "", self.drive.right_encoder or ""
        left, right = map(robot.devices.get, names)
        if not (isinstance(left, Encoder) and isinstance(right, Encoder)):
            pytest.skip(f"{self.description.name} has no encoders on its drive")
        return left, right

    def command(self, robot: Robot, left: float, right: float, seconds: float = SETTLING_S) -> None:
        """Turn the wheels, rad/s, and let time pass."""
        for motor, velocity in zip(self.motors(robot), (left, right), strict=True):
            motor.set_velocity(velocity)
        let_pass(robot, seconds)

    def motion(self, robot: Robot, seconds: float) -> Motion:
        """Let time pass; return how the robot moved, by the truth, or by its encoders where there is none."""
        if robot.truth:
            where = robot.truth.pose
        else:
            left, right = self.encoders(robot)
            where = Odometry(self.drive.geometry, lambda: Wheels(left.read().angle, right.read().angle)).pose
        before = where()
        let_pass(robot, seconds)
        return motion_between(before, where())

    def _skip_without_hook(self, support: TestSupport, hook: str) -> NoReturn:
        self.require(support)
        pytest.skip(f"it does not show how to {support.value}: override {hook}")


@cache
def _described(robot: str) -> RobotDescription:
    return load_robot(robot)


def let_pass(robot: Robot, seconds: float) -> None:
    """Let the robot's time pass."""
    robot.clock.sleep_until(robot.clock.now() + seconds)


def sensors_of(robot: Robot) -> list[Sensor[Any]]:
    """Return everything open that can be read."""
    return [device for device in robot.devices.values() if isinstance(device, Sensor)]


def motion_between(before: Pose, after: Pose) -> Motion:
    """Return the second pose as seen from the first."""
    return Motion(*before.to_local(after.x, after.y), wrap_angle(after.heading - before.heading))
