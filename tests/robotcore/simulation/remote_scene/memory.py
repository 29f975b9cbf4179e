"""A scene without a server, which has the rover of the kinematic simulator as scene objects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from drivers.kinematic.backend import KinematicBackend
from robotcore.description import RobotDescription, StrictModel, load_robot
from robotcore.errors import BackendError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.camera import Camera
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.motor import Motor
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.simulation.remote_scene import (
    CameraOptics,
    ObjectKind,
    Point,
    RawPicture,
    Scene,
    SceneObject,
    State,
    open_in_scene,
)
from robotcore.testing import worlds

STEP_S = 0.05
SECTION: Mapping[str, Any] = {
    "left_motor": {"path": "/rover/leftMotor"},
    "right_motor": {"path": ("/gone", "/rover/rightMotor")},
    "left_encoder": {"path": "/rover/leftMotor"},
    "right_encoder": {"path": "/rover/rightMotor"},
    "nose": {"path": "/rover/nose"},
    "eye": {"path": "/rover/eye"},
    "screen": {"path": "/v1"},
}
OBJECTS = (
    SceneObject(15, "/rover", ObjectKind.SHAPE),
    SceneObject(16, "/rover/leftMotor", ObjectKind.JOINT),
    SceneObject(17, "/rover/rightMotor", ObjectKind.JOINT),
    SceneObject(18, "/rover/nose", ObjectKind.PROXIMITY_SENSOR),
    SceneObject(19, "/rover/eye", ObjectKind.VISION_SENSOR),
    SceneObject(20, "/v1", ObjectKind.VISION_SENSOR),
)
DEVICES = {16: "left_motor", 17: "right_motor", 18: "nose", 19: "eye"}
ENCODERS = {16: "left_encoder", 17: "right_encoder"}


def rover(section: str = "memory", **changes: Any) -> RobotDescription:
    """Return the shipped rover with a section that binds its devices to the objects of `MemoryScene`."""
    return load_robot("rover").model_copy(update={"backends": {section: {**SECTION, **changes}}})


class MemoryScene(Scene):
    """The rover in a kinematic simulation that steps at 20 Hz.

    setup: the robot and the world.
    initial_state: the state of the simulation before the robot is opened.
    """

    def __init__(self, setup: Setup, initial_state: State = State.STOPPED) -> None:
        everything = frozenset(device.name for device in setup.robot.devices)
        world = setup.world or worlds.empty()
        self.robot = KinematicBackend().open(
            replace(setup, devices=everything, world=world, rate_hz=1 / STEP_S, options={})
        )
        self.diary: list[str] = []
        """The received commands, in order."""
        self.present_objects = list(OBJECTS)
        self.screen = CameraOptics(64, 48, None)
        self.eye: CameraOptics | None = None
        self.shown: RawPicture | None = None
        self.defect: str | None = None
        """The result of `diagnose_sensor`."""
        self._state = initial_state
        self._before: dict[int, Point] = {}

    def find(self, path: str) -> SceneObject | None:
        return next((each for each in self.present_objects if each.path == path), None)

    def list_objects(self) -> list[SceneObject]:
        return self.present_objects

    def read_state(self) -> State:
        return self._state

    def start(self) -> None:
        self.diary.append("start")
        self._state = State.RUNNING

    def stop(self) -> None:
        self.diary.append("stop")
        self._state = State.STOPPED

    def read_time_step(self) -> float:
        return STEP_S

    def read_time(self) -> float:
        return self.robot.clock.now()

    def advance(self, steps: int) -> None:
        if self._state is not State.RUNNING:
            raise BackendError("time does not pass")
        for _ in range(steps):
            self._before = {joint: self.read_position(joint) for joint in ENCODERS}
            self.robot.clock.sleep_until(self.robot.clock.now() + STEP_S)

    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        assert type(rad_s) is float
        self.diary.append(f"{DEVICES[joint]} {rad_s:g}")
        motor = self.robot[DEVICES[joint]]
        assert isinstance(motor, Motor)
        motor.set_velocity(rad_s)

    def read_joint_position(self, joint: int) -> float:
        encoder = self.robot[ENCODERS[joint]]
        assert isinstance(encoder, Encoder)
        return math.remainder(encoder.read().angle + 3.0, math.tau)

    def detect(self, sensor: int) -> Point | None:
        nose = self.robot[DEVICES[sensor]]
        assert isinstance(nose, RangeSensor)
        distance = nose.read().distance
        return None if math.isinf(distance) else (0.0, 0.0, distance)

    def diagnose_sensor(self, sensor: int) -> str | None:
        return self.defect

    def read_optics(self, sensor: int) -> CameraOptics:
        if sensor == 20:
            return self.screen
        intrinsics = self.robot.camera.intrinsics
        return self.eye or CameraOptics(intrinsics.width, intrinsics.height, intrinsics.horizontal_fov)

    def read_picture(self, sensor: int) -> RawPicture:
        camera = self.robot[DEVICES[sensor]]
        assert isinstance(camera, Camera)
        image = camera.read().image
        return RawPicture(image[::-1, :, ::-1].tobytes(), image.shape[1], image.shape[0])

    def show(self, sensor: int, picture: RawPicture) -> None:
        self.shown = picture

    def read_position(self, handle: int) -> Point:
        assert self.robot.truth
        side = 1 if handle == 16 else -1
        return (*self.robot.truth.pose().to_world(0.0, side * 0.155 / 2), 0.0325)

    def read_velocity(self, handle: int) -> Point:
        there, before = self.read_position(handle), self._before[handle]
        moved = np.subtract(there, before) / STEP_S
        return (float(moved[0]), float(moved[1]), 0.0)

    def close(self) -> None:
        self.diary.append("leave")


class MemoryBackend(Backend):
    """Opens robots in a `MemoryScene`."""

    name = "memory"
    summary = "for tests"
    capabilities = frozenset({Capability.POSE, Capability.LOCKSTEP})

    def __init__(self) -> None:
        self.scene: MemoryScene | None = None

    def open(self, setup: Setup) -> Robot:
        setup.options_as(_NoOptions)

        def connect() -> MemoryScene:
            self.scene = MemoryScene(setup)
            return self.scene

        return open_in_scene(setup, "memory", connect)


class _NoOptions(StrictModel):
    """This backend has no options."""
