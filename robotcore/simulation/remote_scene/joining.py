"""A robot in somebody's scene: everything found before anything runs, and the scene left as it was found."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass

from robotcore.description import (
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    SimulatedDevice,
)
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Device, MemoryDisplay
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import FollowingClock
from robotcore.simulation.remote_scene.finding import Found, find_all
from robotcore.simulation.remote_scene.pictures import SceneCamera, SceneDisplay, intrinsics_of
from robotcore.simulation.remote_scene.port import Scene
from robotcore.simulation.remote_scene.ranging import SceneRangeSensor
from robotcore.simulation.remote_scene.section import JointPlace, LensPlace, Place, Placed, places
from robotcore.simulation.remote_scene.simulating import Whose, running
from robotcore.simulation.remote_scene.truth import SceneTruth
from robotcore.simulation.remote_scene.wheels import SceneEncoder, SceneMotor

FASTEST_RAD_S = 30.0
"""No wheel turns faster, where the description does not say."""


def _none(_joints: Mapping[str, int]) -> tuple[CutoffSpec, ...]:
    """Return no cutoffs: some simulations stand when nobody steps them."""
    return ()


def join(
    setup: Setup,
    section: str,
    connect: Callable[[], Scene],
    whose: Whose = Whose.OURS,
    *,
    is_stepped: bool = True,
    cutoffs: Callable[[Mapping[str, int]], Iterable[CutoffSpec]] = _none,
) -> Robot:
    """Open a robot whose devices are objects of a scene, as that ``section`` of its file says.

    Its clock is stepped, or follows the scene's time. Its motors stand from the first step on; ``cutoffs`` makes of the
    motors' joints, by name, how the guardian stops them. Raises DescriptionError
    before it connects, UsageError where the rate does not fit the time step, and what `find_all` and `running` raise;
    what was opened by then is closed again.
    """
    placed = places(setup.robot, section, setup.devices)
    with ExitStack() as undo:
        beneath = undo.enter_context(ExitStack())
        scene = connect()
        beneath.callback(scene.close)
        found = find_all(setup.robot.name, placed, scene)
        stepped = SteppedClock(setup.rate_hz, scene.advance, scene.time_step()) if is_stepped else None
        beneath.enter_context(running(scene, whose))
        for joint in _joints(placed, found).values():
            scene.set_joint_velocity(joint, 0.0)  # the scene, or whoever was here before, may have left it turning
        if stepped:
            scene.advance(1)  # before its first step a scene shows nothing
        clock = stepped or FollowingClock(scene.time)
        undo.callback(clock.close)
        joined = _Joined(setup.robot, scene, clock, {each.told.name: each.place for each in placed}, found)
        devices = []
        for told in setup.chosen:
            devices.append(device := joined.open(told))
            undo.callback(device.close)
        truth = _truth(setup.robot, scene, found)
        specs = cutoffs(_joints(placed, found))
        robot = Robot(setup.robot.name, clock, devices, truth=truth, release=beneath.close, cutoffs=specs)
        undo.pop_all()
    return robot


def _joints(placed: Iterable[Placed], found: Found) -> dict[str, int]:
    """Return the joints of the motors."""
    motors = (each.told.name for each in placed if isinstance(each.told, MotorDescription))
    return {name: joint.handle for name in motors if (joint := found[name])}


@dataclass(frozen=True)
class _Joined:
    """A scene with the objects that a robot's devices are, and the clock that they are read by."""

    robot: RobotDescription
    scene: Scene
    clock: Clock
    places: Mapping[str, Place]
    found: Found

    def open(self, told: SimulatedDevice) -> Device:
        """Open a device; a display that has no object is kept in memory."""
        thing = self.found.get(told.name)
        if thing is None:
            return MemoryDisplay(told.name)
        if isinstance(told, MotorDescription):
            return SceneMotor(told, self.scene, thing.handle, is_reversed=self._is_reversed(told))
        if isinstance(told, EncoderDescription):
            return self._encoder(told, thing.handle)
        if isinstance(told, RangeSensorDescription):
            return SceneRangeSensor(told, self.scene, thing.handle, self.clock)
        if isinstance(told, CameraDescription):
            return self._camera(told, thing.handle)
        display: DisplayDescription = told  # of a new kind of device, the type checker tells
        return SceneDisplay(display.name, self.scene, thing.handle)

    def _encoder(self, told: EncoderDescription, joint: int) -> SceneEncoder:
        limits = [motor.max_velocity_rad_s for motor in self.robot.all_of(MotorDescription)]
        quarter_turn_s = math.pi / 2 / max(limits, default=FASTEST_RAD_S)
        is_reversed = self._is_reversed(told)
        return SceneEncoder(told, self.scene, joint, self.clock, quarter_turn_s, is_reversed=is_reversed)

    def _camera(self, told: CameraDescription, sensor: int) -> SceneCamera:
        place = self.places[told.name]
        as_found = isinstance(place, LensPlace) and place.as_found
        intrinsics = intrinsics_of(told, self.scene.lens(sensor), as_found=as_found)
        return SceneCamera(told.name, intrinsics, self.scene, sensor, self.clock)

    def _is_reversed(self, told: SimulatedDevice) -> bool:
        place = self.places[told.name]
        return isinstance(place, JointPlace) and place.reversed


def _truth(robot: RobotDescription, scene: Scene, found: Found) -> SceneTruth | None:
    """Return the truth by the drive's joints, where they are open."""
    if robot.drive is None:
        return None
    left, right = found.get(robot.drive.left), found.get(robot.drive.right)
    return SceneTruth(scene, left.handle, right.handle) if left and right else None
