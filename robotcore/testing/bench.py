"""The test bench, which is the base class of all rules: it opens and moves a robot of the tested backend."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from enum import Enum
from functools import cache, partial
from typing import Any, ClassVar, NamedTuple, NoReturn

import pytest

from robotcore.description import AckermannDrive, Drive, RobotDescription, WorldDescription, load_robot
from robotcore.errors import DeviceError, UnmetNeedError, UsageError
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.device import Sensor
from robotcore.hal.drive import Odometry, WheelPath
from robotcore.hal.robot import Robot, Role
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.motor import Motor
from robotcore.kinds.servo import Servo
from robotcore.runtime.needs import needed_devices
from robotcore.testing import worlds
from robotcore.testing.fakes import Gate
from robotcore.testing.plugin import UNMEASURED_MOTION

__all__ = ["Motion", "TestBench"]

RATE_HZ = 20.0
SETTLING_S = 0.5
"""The wheels must turn at the commanded velocity after this time, in seconds."""

STANDSTILL_M = 0.002
"""A robot that moves less than this distance stands still, in metres."""

UNPLUGGED_S = 6.0
"""The calls of a device must raise an error after this time without its hardware, in seconds."""

MAX_CALL_S = 0.02
"""A command or a reading must not take longer, in seconds. A tick has those of all devices."""

NO_TRUTH = (
    "the robot has no ground truth. Open it as Robot(..., truth=...), or remove POSE and CONTACTS from capabilities"
)
"""The message about a simulator without the truth that its capabilities promise."""


class TestSupport(str, Enum):
    """What some rules require of a test bench. A suite lists in ``lacks`` what its test bench cannot do.

    >>> lacks = {TestSupport.WORLD: "the robot stands on a table"}  # of a ConformanceSuite
    >>> [support.name for support in TestSupport]
    ['WORLD', 'MOTION', 'REPRODUCIBLE', 'LOST_ECHO', 'SLOW_HARDWARE', 'UNPLUGGING', 'CUTOFFS']
    """

    __test__ = False  # pytest collects classes whose name begins with Test

    WORLD = "detect the world of the test"
    """The sensors detect the obstacles of the world that the test opens."""

    MOTION = "move as commanded"
    """The robot moves as commanded, so that a test can measure its motion."""

    REPRODUCIBLE = "repeat a run exactly"
    """A second run with the same commands reads equal samples."""

    LOST_ECHO = "suppress an echo"
    """`TestBench.lose_echoes` can suppress the echoes of the range sensor."""

    SLOW_HARDWARE = "delay the hardware"
    """`TestBench.open_gated` can delay the answers of the hardware."""

    UNPLUGGING = "unplug the hardware"
    """`TestBench.unplug` can let every call of the hardware fail."""

    CUTOFFS = "stop the wheels by cutoffs"
    """The cutoffs reach the hardware while the robot is open, and nothing repeats the last command."""


class Motion(NamedTuple):
    """A motion of the robot, with x and y along the axes of its pose before the motion.

    >>> from robotcore.testing.bench import Motion
    >>> Motion(forward=0.5, left=0.0, turn=0.1).forward
    0.5
    """

    forward: float
    """The motion along the x axis, in metres."""

    left: float
    """The motion along the y axis, in metres."""

    turn: float
    """The change of the heading, in radians, positive to the left."""


class TestBench:
    """The test bench on which the rules test a backend. A suite sets ``backend``, and other attributes if necessary.

    >>> from drivers.kinematic.backend import KinematicBackend
    >>> from robotcore.testing import TestSupport
    >>> from robotcore.testing.bench import TestBench
    >>> class KinematicBench(TestBench):
    ...     backend = KinematicBackend
    ...     lacks = {TestSupport.SLOW_HARDWARE: "a simulator has no hardware"}
    >>> KinematicBench().description.name
    'rover'
    """

    backend: ClassVar[type[Backend]]
    """The backend to test."""

    robot: ClassVar[str] = "rover"
    """The name or the file of the robot's description."""

    options: ClassVar[Mapping[str, Any]] = {}
    """The backend's options by name."""

    lacks: ClassVar[Mapping[TestSupport, str]] = {}
    """What the test bench cannot do, each with a reason. The rules that require it are skipped."""

    def __init_subclass__(cls) -> None:
        """Raise UsageError if an attribute of the suite has the wrong type."""
        backend = getattr(cls, "backend", Backend)
        if not (isinstance(backend, type) and issubclass(backend, Backend)):
            text = f"{cls.__name__}.backend is {backend!r}. Set it to the class of the backend"
            raise UsageError(text, kind="suite-backend", backend=backend)
        if unknown := [each for each in cls.lacks if not isinstance(each, TestSupport)]:
            names = ", ".join(each.name for each in TestSupport)
            text = f"{cls.__name__}.lacks has {unknown[0]!r}. Its keys are members of TestSupport: {names}"
            raise UsageError(text, kind="suite-lacks", key=unknown[0])

    def open(self, setup: Setup) -> Robot:
        """Open the devices of a setup with the backend. A suite may override this method."""
        return self.backend().open(setup)

    def lose_echoes(self, robot: Robot) -> None:
        """Suppress all further echoes of the range sensor. By default the rule is skipped."""
        self._skip_without_hook(TestSupport.LOST_ECHO, "lose_echoes")

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        """Open a robot whose fake hardware calls ``gate.pass_through`` before each answer.

        By default the rule is skipped. A suite with fake hardware overrides this method.
        """
        self._skip_without_hook(TestSupport.SLOW_HARDWARE, "open_gated")

    def unplug(self, robot: Robot) -> None:
        """Let every further call of the robot's fake hardware fail, as the vendor's library does for a pulled cable.

        By default the rule is skipped. A suite with fake hardware overrides this method.
        """
        self._skip_without_hook(TestSupport.UNPLUGGING, "unplug")

    def measure_pose(self, robot: Robot) -> Pose | None:
        """Return the robot's pose, measured from outside, if the backend has no truth. By default there is none.

        A suite with fake hardware overrides this method, and returns the pose of the fake robot. The rules compare
        poses, so the origin does not matter. One rule also calls it for a closed robot. Without this method they
        measure motion by the encoders, which hide that a motor and its encoder are both reversed.
        """
        return None

    @pytest.fixture(autouse=True)
    def _require_installed_backend(self) -> None:
        backend = self.backend()
        if not backend.is_installed:
            pytest.skip(f"{backend.name} is not installed: {backend.remedy}")

    @property
    def description(self) -> RobotDescription:
        """The description of the robot."""
        return _load_robot(self.robot)

    @property
    def openable(self) -> frozenset[str]:
        """The names of the devices that the backend can open."""
        return self.backend().openable(self.description, self.options)

    @property
    def drive(self) -> Drive:
        """The description of the drive. If the robot has none, the rule is skipped."""
        return self.description.drive or pytest.skip(f"{self.description.name} has no drive")

    def build_setup(self, world: WorldDescription | None = None, devices: Iterable[str] | None = None) -> Setup:
        """Return the setup for `open`.

        world: the world of the test, by default open ground.
        devices: the names of the devices to open, by default all that the backend can open.
        """
        names = self.openable if devices is None else devices
        return Setup(self.description, world or worlds.empty(), frozenset(names), RATE_HZ, options=self.options)

    def open_robot(self, world: WorldDescription | None = None, *roles: Role) -> Robot:
        """Open the devices of these roles; without roles, all devices that the backend can open.

        world: the world of the test, by default open ground.
        """
        try:
            devices = needed_devices(self.description, roles) if roles else None
        except UnmetNeedError as error:
            pytest.skip(str(error))
        return self.open(self.build_setup(world, devices))

    @contextmanager
    def open_unplugged(self, *roles: Role) -> Iterator[Robot]:
        """Open a robot as `open_robot` does, and unplug its hardware. At the end, ignore the errors of closing it."""
        robot = self.open_robot(None, *roles)
        try:
            self.unplug(robot)
            yield robot
        finally:
            with suppress(DeviceError):
                robot.close()

    def require(self, *needed: TestSupport | Capability) -> None:
        """Skip the rule, with a reason, if the test bench or the backend cannot do one of these."""
        for each in needed:
            if isinstance(each, TestSupport) and each in self.lacks:
                pytest.skip(f"the test bench cannot {each.value}: {self.lacks[each]}")
            if isinstance(each, Capability) and each not in self.backend.capabilities:
                pytest.skip(f"backend {self.backend.name!r} does not have the capability {each.value}")

    def get_motors(self, robot: Robot) -> tuple[Motor, ...]:
        """Return the motors of the drive, those on the left first."""
        motors = []
        for name in self.drive.motors:
            motor = robot[name]
            assert isinstance(motor, Motor), f"{motor.name} is a {type(motor).__name__}, not a Motor"
            motors.append(motor)
        return tuple(motors)

    def get_encoders(self, robot: Robot) -> tuple[Encoder, Encoder]:
        """Return a left and a right encoder of the drive. If the drive has none, the rule is skipped."""
        return self._find_encoders(robot) or pytest.skip(f"the drive of {self.description.name} has no encoders")

    def command_wheels(self, robot: Robot, left: float, right: float, seconds: float = SETTLING_S) -> None:
        """Command the velocities of the wheels on each side in rad/s, and sleep for ``seconds``.

        A drive that steers drives the arc of these velocities, or the sharpest that it can. If they are those of a turn
        on the spot, the rule is skipped.
        """
        if isinstance(self.drive, AckermannDrive) and (left, right) != (0.0, 0.0):
            left, right = self._steer_along_arc(robot, self.drive, left, right)
        for motor in self.get_motors(robot):
            sides = [left] * (motor.name in self.drive.left_motors) + [right] * (motor.name in self.drive.right_motors)
            motor.set_velocity(sum(sides) / len(sides))
        sleep(robot, seconds)

    def _steer_along_arc(self, robot: Robot, drive: AckermannDrive, left: float, right: float) -> tuple[float, float]:
        """Steer along the arc of two wheel velocities. Return the velocities that have the same mean on this arc."""
        mean, servo = (left + right) / 2, robot[drive.steering]
        if not mean:
            pytest.skip(f"{self.description.name} cannot turn on the spot")
        assert isinstance(servo, Servo), f"{servo.name} is a {type(servo).__name__}, not a Servo"
        least, greatest = self.description.curvatures
        curvature = max(least, min((right - left) / mean / drive.track_m, greatest))
        servo.set_angle(drive.to_angle_rad(curvature))
        difference = mean * curvature * drive.track_m / 2
        return mean - difference, mean + difference

    def measure_motion(self, robot: Robot, seconds: float) -> Motion:
        """Return the robot's motion in the next ``seconds``: by its true pose, else by `measure_pose` or its encoders.

        If there is none of these, the rule is skipped, and the plug-in warns.
        """
        read_pose = self._choose_pose(robot)
        before = read_pose()
        sleep(robot, seconds)
        return compute_motion(before, read_pose())

    def read_pose(self, robot: Robot) -> Pose:
        """Return the robot's true pose, or else the result of `measure_pose`. Without these, the rule is skipped."""
        if robot.truth:
            return robot.truth.pose()
        pose = self.measure_pose(robot)
        if pose is None:
            self.require(Capability.POSE)
        assert pose is not None, NO_TRUTH
        return pose

    def _choose_pose(self, robot: Robot) -> Callable[[], Pose]:
        if robot.truth or self.measure_pose(robot) is not None:
            return partial(self.read_pose, robot)
        left, right = self._find_encoders(robot) or pytest.skip(UNMEASURED_MOTION)
        return Odometry(self.drive.geometry, lambda: WheelPath(Wheels(left.read().angle, right.read().angle))).pose

    def _find_encoders(self, robot: Robot) -> tuple[Encoder, Encoder] | None:
        sides = self.drive.left_encoders, self.drive.right_encoders
        left, right = (next(filter(None, map(robot.devices.get, names)), None) for names in sides)
        return (left, right) if isinstance(left, Encoder) and isinstance(right, Encoder) else None

    def _skip_without_hook(self, support: TestSupport, hook: str) -> NoReturn:
        self.require(support)
        pytest.skip(f"the suite does not override {hook}(), so the test bench cannot {support.value}")


@cache
def _load_robot(robot: str) -> RobotDescription:
    return load_robot(robot)


def sleep(robot: Robot, seconds: float) -> None:
    """Sleep for ``seconds`` of the robot's clock."""
    robot.clock.sleep_until(robot.clock.now() + seconds)


def raises_in_time(robot: Robot, call: Callable[[], object]) -> bool:
    """Repeat a call, and return whether it raises DeviceError within `UNPLUGGED_S`."""
    end = robot.clock.now() + UNPLUGGED_S
    while robot.clock.now() < end:
        try:
            call()
        except DeviceError:
            return True
        sleep(robot, 1 / RATE_HZ)
    return False


def measure_time(call: Callable[[], object]) -> float:
    """Make a call, and return how long it took, in seconds of wall time."""
    clock = MonotonicClock()
    call()
    return clock.now()


def list_sensors(robot: Robot) -> list[Sensor[Any]]:
    """Return the robot's open sensors."""
    return [device for device in robot.devices.values() if isinstance(device, Sensor)]


def compute_motion(before: Pose, after: Pose) -> Motion:
    """Return the motion from the pose ``before`` to the pose ``after``."""
    return Motion(*before.to_local(after.x, after.y), wrap_angle(after.heading - before.heading))
