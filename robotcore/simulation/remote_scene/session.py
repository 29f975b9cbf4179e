"""Open a robot in an existing scene, start its simulation, and leave both as they were found."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from enum import Enum

from robotcore.description import (
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    SimulatedDevice,
)
from robotcore.errors import BackendError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Device, MemoryDisplay
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import ServerClock
from robotcore.simulation.remote_scene.bindings import (
    CameraBinding,
    Found,
    JointBinding,
    ObjectBinding,
    SceneBinding,
    find_all,
    read_bindings,
)
from robotcore.simulation.remote_scene.devices import (
    SceneCamera,
    SceneDisplay,
    SceneEncoder,
    SceneMotor,
    SceneRangeSensor,
    SceneTruth,
    intrinsics_of,
)
from robotcore.simulation.remote_scene.interface import Scene, State

FASTEST_RAD_S = 30.0
"""No wheel turns faster, where the description does not say."""


class Owner(str, Enum):
    """Whose business it is to start the simulation where it is stopped, and then to stop it again.

    One that is found running is left running either way.
    """

    OURS = "ours"
    THEIRS = "theirs"


def _no_cutoffs(_joints: Mapping[str, int]) -> tuple[CutoffSpec, ...]:
    """Return no cutoffs: some simulations stand when nobody steps them."""
    return ()


def open_in_scene(
    setup: Setup,
    section: str,
    connect: Callable[[], Scene],
    owner: Owner = Owner.OURS,
    *,
    is_stepped: bool = True,
    cutoffs: Callable[[Mapping[str, int]], Iterable[CutoffSpec]] = _no_cutoffs,
) -> Robot:
    """Open a robot whose devices are objects of a scene, as that ``section`` of its file says.

    Its clock is stepped, or follows the scene's time. Its motors stand from the first step on; ``cutoffs`` makes of the
    motors' joints, by name, how the guardian stops them. Raises DescriptionError
    before it connects, UsageError where the rate does not fit the time step, and what `find_all` and `running` raise;
    what was opened by then is closed again.
    """
    bound = read_bindings(setup.robot, section, setup.devices)
    with ExitStack() as undo:
        beneath = undo.enter_context(ExitStack())
        scene = connect()
        beneath.callback(scene.close)
        found = find_all(setup.robot.name, bound, scene)
        stepped = SteppedClock(setup.rate_hz, scene.advance, scene.time_step()) if is_stepped else None
        beneath.enter_context(keep_running(scene, owner))
        for joint in _joints(bound, found).values():
            scene.set_joint_velocity(joint, 0.0)  # the scene, or whoever was here before, may have left it turning
        if stepped:
            scene.advance(1)  # before its first step a scene shows nothing
        clock = stepped or ServerClock(scene.time)
        undo.callback(clock.close)
        joined = _DeviceOpener(setup.robot, scene, clock, {each.description.name: each.place for each in bound}, found)
        devices = []
        for description in setup.chosen:
            devices.append(device := joined.open(description))
            undo.callback(device.close)
        truth = _ground_truth(setup.robot, scene, found)
        specs = cutoffs(_joints(bound, found))
        robot = Robot(setup.robot.name, clock, devices, truth=truth, release=beneath.close, cutoffs=specs)
        undo.pop_all()
    return robot


def _joints(bound: Iterable[SceneBinding], found: Found) -> dict[str, int]:
    """Return the joints of the motors."""
    motors = (each.description.name for each in bound if isinstance(each.description, MotorDescription))
    return {name: joint.handle for name in motors if (joint := found[name])}


@dataclass(frozen=True)
class _DeviceOpener:
    """A scene with the objects that a robot's devices are, and the clock that they are read by."""

    robot: RobotDescription
    scene: Scene
    clock: Clock
    bindings: Mapping[str, ObjectBinding]
    found: Found

    def open(self, description: SimulatedDevice) -> Device:
        """Open a device; a display that has no object is kept in memory."""
        thing = self.found.get(description.name)
        if thing is None:
            return MemoryDisplay(description.name)
        if isinstance(description, MotorDescription):
            return SceneMotor(description, self.scene, thing.handle, is_reversed=self._is_reversed(description))
        if isinstance(description, EncoderDescription):
            return self._encoder(description, thing.handle)
        if isinstance(description, RangeSensorDescription):
            return SceneRangeSensor(description, self.scene, thing.handle, self.clock)
        if isinstance(description, CameraDescription):
            return self._camera(description, thing.handle)
        display: DisplayDescription = description  # of a new kind of device, the type checker tells
        return SceneDisplay(display.name, self.scene, thing.handle)

    def _encoder(self, description: EncoderDescription, joint: int) -> SceneEncoder:
        limits = [motor.max_velocity_rad_s for motor in self.robot.all_of(MotorDescription)]
        quarter_turn_s = math.pi / 2 / max(limits, default=FASTEST_RAD_S)
        is_reversed = self._is_reversed(description)
        return SceneEncoder(description, self.scene, joint, self.clock, quarter_turn_s, is_reversed=is_reversed)

    def _camera(self, description: CameraDescription, sensor: int) -> SceneCamera:
        place = self.bindings[description.name]
        as_found = isinstance(place, CameraBinding) and place.as_found
        intrinsics = intrinsics_of(description, self.scene.optics(sensor), as_found=as_found)
        return SceneCamera(description.name, intrinsics, self.scene, sensor, self.clock)

    def _is_reversed(self, description: SimulatedDevice) -> bool:
        place = self.bindings[description.name]
        return isinstance(place, JointBinding) and place.reversed


def _ground_truth(robot: RobotDescription, scene: Scene, found: Found) -> SceneTruth | None:
    """Return the truth by the drive's joints, where they are open."""
    if robot.drive is None:
        return None
    left, right = found.get(robot.drive.left), found.get(robot.drive.right)
    return SceneTruth(scene, left.handle, right.handle) if left and right else None


@contextmanager
def keep_running(scene: Scene, owner: Owner) -> Iterator[None]:
    """Let the simulation run meanwhile, and leave it as it was found.

    Raises BackendError where it is paused, or stopped and somebody else's to start.
    """
    state = scene.state()
    if state is State.PAUSED:
        raise BackendError("the simulation is paused. Let it go on there, or stop it, and run this again")
    if state is State.STOPPED and owner is Owner.THEIRS:
        raise BackendError(
            "the simulation is stopped, and with option simulation=theirs it is started by others. "
            "Start it there, or leave the option out"
        )
    try:
        scene.start()
        yield
    finally:
        if state is State.STOPPED:
            scene.stop()
