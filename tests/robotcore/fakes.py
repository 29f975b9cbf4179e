"""Devices without hardware, and a rover with these devices and the layers of a real run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DeviceError
from robotcore.geometry import Pose, Twist
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.joint import Joints
from robotcore.hal.robot import Robot, Role
from robotcore.hal.truth import TruthSource
from robotcore.kinds.camera import Camera, Frame
from robotcore.kinds.display import MemoryDisplay
from robotcore.kinds.encoder import Angle, Encoder
from robotcore.kinds.motor import Motor
from robotcore.kinds.range_sensor import Range, RangeSensor
from robotcore.optics import Image, Intrinsics
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.layers import AssembledRobot, assemble
from robotcore.safety.sensor_ahead import SensorAhead

ROVER = load_robot("rover")
assert ROVER.drive
UNHURRIED = ROVER.model_copy(update={"drive": ROVER.drive.model_copy(update={"max_acceleration_rad_s2": None})})
"""The rover without an acceleration limit."""

STANDING = Twist(0.0, 0.0)
EYE = Intrinsics(32, 24, math.radians(60))


class NullMotor(Motor):
    """Collects its commands. If ``is_broken``, each command fails instead."""

    def __init__(self, name: str, max_velocity: float = 12.0) -> None:
        super().__init__(name, max_velocity)
        self.sent: list[float] = []
        self.received: list[float] = []
        self.is_broken = False
        self.on_command: Callable[[float], object] = lambda _: None
        self.releases = 0

    def _apply(self, rad_s: float) -> None:
        self.received.append(rad_s)
        self.on_command(rad_s)
        if self.is_broken:
            raise DeviceError(self.name, "no current")
        self.sent.append(rad_s)

    def _release(self) -> None:
        self.releases += 1


class NullRange(RangeSensor):
    """Returns ``distance``, captured ``age`` seconds ago, and counts the reads."""

    def __init__(self, clock: Clock, name: str = "nose", distance: float = math.inf) -> None:
        super().__init__(name, min_range=0.02, max_range=2.0, cone=0.5)
        self.distance, self.age, self.reads = distance, 0.0, 0
        self._clock = clock

    def _newest(self) -> Range:
        self.reads += 1
        return Range(self.distance, self._clock.now() - self.age, self.reads)


def look_ahead(sensor: RangeSensor, clock: Clock) -> SensorAhead:
    """Return a sensor with the name and the mount of the rover's range sensor, for the range guard."""
    rover = load_robot("rover")
    return SensorAhead(sensor, rover, Joints(rover, clock))


class NullEncoder(Encoder):
    """Returns ``angle``, and counts the reads."""

    def __init__(self, clock: Clock, name: str) -> None:
        super().__init__(name)
        self.angle, self.reads = 0.0, 0
        self._clock = clock

    def _newest(self) -> Angle:
        self.reads += 1
        return Angle(self.angle, self._clock.now(), self.reads)


class NullCamera(Camera):
    """Returns ``image``."""

    def __init__(self, clock: Clock, name: str = "eye") -> None:
        super().__init__(name, EYE)
        self.image = picture()
        self._clock = clock
        self._count = 0

    def _newest(self) -> Frame:
        self._count += 1
        return Frame(self.image, self._clock.now(), self._count)


class StillTruth:
    """The truth of a robot that does not move."""

    def __init__(self, pose: Pose, twist: Twist = STANDING, contacts: int = 0) -> None:
        self._truth = pose, twist, contacts

    def pose(self) -> Pose:
        return self._truth[0]

    def twist(self) -> Twist:
        return self._truth[1]

    def contacts(self) -> int:
        return self._truth[2]


def picture(colour: tuple[int, int, int] = (0, 0, 0), intrinsics: Intrinsics = EYE) -> Image:
    """Return a read-only picture of one BGR colour."""
    image = np.full((intrinsics.height, intrinsics.width, 3), colour, dtype=np.uint8)
    image.flags.writeable = False
    return image


@dataclass
class Rig:
    """A rover of null devices on a stepped clock."""

    rate_hz: float = 20.0
    description: RobotDescription = ROVER
    names: Iterable[str] = ("left_motor", "right_motor", "nose", "eye", "screen")
    truth: TruthSource | None = None
    steps: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.clock = SteppedClock(self.rate_hz, self.steps.append)
        self.left, self.right = NullMotor("left_motor"), NullMotor("right_motor")
        self.nose, self.eye, self.screen = NullRange(self.clock), NullCamera(self.clock), MemoryDisplay("screen")
        self._assembled: AssembledRobot | None = None

    @property
    def devices(self) -> list[Device]:
        every = (self.left, self.right, self.nose, self.eye, self.screen)
        return [device for device in every if device.name in self.names]

    @property
    def raw(self) -> Robot:
        return Robot("rig", self.clock, self.devices, truth=self.truth)

    @property
    def assembled(self) -> AssembledRobot:
        """The rover with its layers."""
        self._assembled = self._assembled or assemble(self.raw, self.description, self.rate_hz)
        return self._assembled

    @property
    def robot(self) -> Robot:
        return self.assembled.robot

    def commit(self) -> None:
        """End the tick as the loop does, and let time pass until the next tick."""
        assert self.assembled.command_filter
        self.assembled.command_filter.commit()
        self.sleep(1 / self.rate_hz)

    def sleep(self, seconds: float) -> None:
        clock = self.assembled.clock
        clock.sleep_until(clock.now() + seconds)

    @property
    def wheels(self) -> tuple[float, float]:
        """The last commands of the two motors, in rad/s."""
        return self.left.sent[-1], self.right.sent[-1]


class RigBackend(Backend):
    """Opens a new rig in each call."""

    name = "rig"
    summary = "null devices"
    capabilities = frozenset({Capability.LOCKSTEP})

    def __init__(self, prepare: Callable[[Rig], None] = lambda _: None) -> None:
        self._prepare = prepare
        self.rigs: list[Rig] = []

    @property
    def rig(self) -> Rig:
        """The last opened rig."""
        return self.rigs[-1]

    def open(self, setup: Setup) -> Robot:
        self.rigs.append(rig := Rig(setup.rate_hz, setup.robot, setup.devices))
        self._prepare(rig)
        return rig.raw


class FunctionApp(Behaviour):
    """An app that calls a function in each tick."""

    needs = frozenset({Role.DRIVE})

    def __init__(self, function: Callable[[Robot], Status | None]) -> None:
        self._function = function

    def step(self, robot: Robot) -> Status:
        return self._function(robot)  # type: ignore[return-value]  # some tests return no status
