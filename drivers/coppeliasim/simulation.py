"""One robot in one world: both are built in a scene, simulated and removed again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from drivers.coppeliasim.builder import FORWARD, Placement, SceneBuilder, place_mount, place_on_floor
from drivers.coppeliasim.connection import LOADING_S
from drivers.coppeliasim.models import BuiltEncoder, BuiltMotor, BuiltRobot, BuiltWorld, build_robot, build_world
from drivers.coppeliasim.restore import (
    Undo,
    finish_building,
    release,
    require_empty,
    restore,
    save_scene_state,
    undo_collections,
)
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.sensors import (
    FanRangeSensor,
    ProximityRangeSensor,
    VisionSensorSpec,
    add_fan,
    add_proximity_sensor,
    add_vision_sensor,
    proximity_works,
    require_depth,
)
from drivers.coppeliasim.truth import ContactCounter, CoppeliaSimTruth
from robotcore.description import (
    AnyDevice,
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    SimulatedDevice,
    WorldDescription,
)
from robotcore.errors import BackendError, DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device
from robotcore.simulation.remote_scene import State
from robotcore.simulation.remote_scene.devices import SceneCamera, SceneDisplay


class Simulation:
    """What was built, and the clock that moves it."""

    def __init__(self, scene: CoppeliaSimScene, setup: Setup, built: BuiltScene) -> None:
        self._scene, self._built = scene, built
        self._chosen = setup.chosen
        self._motors: list[BuiltMotor] = []
        body = built.robot.body
        self._touches = ContactCounter(scene.connection, body, built.world.things)
        self.clock = SteppedClock(setup.rate_hz, self._advance, scene.read_time_step())
        self.truth = CoppeliaSimTruth(scene.connection, body, built.robot.frame, self._touches)

    def start(self) -> None:
        """Let it run, in lockstep; before its first step nothing has come to rest."""
        self._scene.start()
        self._scene.advance(1)

    def open(self, description: SimulatedDevice) -> Device:
        """Open one device; raises DeviceError where it sits on a wheel that is not there."""
        scene, clock = self._scene, self.clock
        if isinstance(description, MotorDescription):
            motor = BuiltMotor(scene, description, self._joint_of(description.name), clock.step)
            self._motors.append(motor)
            return motor
        if isinstance(description, EncoderDescription):
            return BuiltEncoder(scene, description, self._joint_of(description.name), clock)
        sensor = self._built.sensors[description.name]
        if isinstance(description, RangeSensorDescription):
            if self._built.has_proximity:
                return ProximityRangeSensor(scene, description, sensor, clock)
            return FanRangeSensor(scene.connection, description, sensor, clock)
        if isinstance(description, CameraDescription):
            return SceneCamera(description.name, description.intrinsics, scene, sensor, clock)
        display: DisplayDescription = description  # of a new kind of device, the type checker tells
        return SceneDisplay(display.name, scene, sensor)

    @property
    def driven(self) -> Mapping[str, int]:
        """The joints of the motors that are open, by their names."""
        return {motor.name: self._joint_of(motor.name) for motor in self._motors}

    @property
    def notes(self) -> Sequence[str]:
        """Say what measures distances, where anything does."""
        by = "a proximity sensor" if self._built.has_proximity else "pictures of depth; there are no proximity sensors"
        names = [description.name for description in self._chosen if isinstance(description, RangeSensorDescription)]
        return [f"{name} measures by {by}" for name in names]

    def _advance(self, steps: int) -> None:
        self._scene.connection.run_batch(partial(self._step, steps))

    def _step(self, steps: int) -> None:
        for _ in range(steps):
            for motor in self._motors:
                motor.drive()
            self._scene.advance(1)
            self._touches.look()

    def _joint_of(self, name: str) -> int:
        if name not in self._built.robot.joints:
            raise DeviceError(name, "sits on no wheel; name it in the robot's drive")
        return self._built.robot.joints[name]


SCREEN = (320, 240)
_SCREEN_FOV_RAD, _SCREEN_HEIGHT_M = 1.0, 3.0
_SAME = 1e-6


class BuiltScene(NamedTuple):
    """What was built: the handles of world and robot, and of the sensors by their devices' names."""

    world: BuiltWorld
    robot: BuiltRobot
    sensors: Mapping[str, int]
    has_proximity: bool
    """Whether distances come from proximity sensors; else from pictures of depth."""


def clear_scene(scene: CoppeliaSimScene, builder: SceneBuilder) -> None:
    """Remove what a program that was killed has left; raise BackendError where somebody else uses the scene."""
    if (state := scene.read_state()) is not State.STOPPED:
        raise BackendError(
            f"coppeliasim: a simulation of somebody's is {state.value} in the CoppeliaSim at "
            f"{scene.connection.address}. Stop it, and run again"
        )
    restore(builder)
    require_empty(builder)


def leave_scene(scene: CoppeliaSimScene, builder: SceneBuilder, *, keep: bool) -> None:
    """Stop, and remove what was made and give back what was changed, or hand it over where it is to be kept.

    Where the simulator is gone or hangs, that is left to whoever comes next.
    """
    if scene.connection.is_lost:
        return
    scene.stop()
    if keep:
        release(builder)
    else:
        restore(builder)


def build_scene(scene: CoppeliaSimScene, builder: SceneBuilder, setup: Setup, world: WorldDescription) -> BuiltScene:
    """Build the world and the robot in it, in a scene that has room, and let a tick be a step of its time."""
    built_world = build_world(builder, world)
    has_proximity = proximity_works(builder, scene.detect)
    if not has_proximity and any(isinstance(description, RangeSensorDescription) for description in setup.chosen):
        require_depth(builder, scene.connection)
    undo: list[Undo] = [_undo_engine(builder), _undo_time_step(scene, builder)]
    undo += undo_collections(built_world.root, (built_world.seen, built_world.met))
    save_scene_state(builder, built_world.root, world.light, undo)
    _set_engine(builder)
    _set_time_step(scene, builder, 1 / setup.rate_hz)
    robot = build_robot(builder, setup.robot, world.start.pose)
    sensors = _Sensors(
        builder, robot.body, place_on_floor(world.start.pose), built_world, sky_grey(world), has_proximity
    )
    handles = {
        description.name: handle for description in setup.chosen if (handle := sensors.add(description)) is not None
    }
    finish_building(builder, built_world.root)
    return BuiltScene(built_world, robot, handles, has_proximity)


def sky_grey(world: WorldDescription) -> float:
    """Return the grey, from 0 to 1, that is next to the sky's colour."""
    return sum(world.light.sky_colour) / 3 / 255


class _Sensors(NamedTuple):
    """Where and how sensors are added to a robot's body."""

    builder: SceneBuilder
    body: int
    frame: Placement
    world: BuiltWorld
    sky: float
    has_proximity: bool

    def add(self, description: AnyDevice) -> int | None:
        """Make what a device is, and return its handle; None where it is no sensor."""
        if isinstance(description, RangeSensorDescription):
            add = add_proximity_sensor if self.has_proximity else add_fan
            return add(self.builder, description, self.body, self.frame, self.world.met)
        if isinstance(description, CameraDescription):
            size, fov = (description.width_px, description.height_px), description.horizontal_fov_rad
            eye = VisionSensorSpec(size, fov, empty=self.sky, seen=self.world.seen, ignored="depth")
            return add_vision_sensor(
                self.builder, eye, description.name, self.frame.at(place_mount(description.mount)), self.body
            )
        if isinstance(description, DisplayDescription):
            place = self.frame.at(FORWARD._replace(z=_SCREEN_HEIGHT_M))
            return add_vision_sensor(
                self.builder, VisionSensorSpec(SCREEN, _SCREEN_FOV_RAD), description.name, place, self.body
            )
        return None


def _undo_engine(builder: SceneBuilder) -> Undo:
    """Return the call that lets what computes the physics be as it is now."""
    parameter = builder.constant("intparam_dynamic_engine")
    return "setInt32Param", parameter, builder.call("getInt32Param", parameter)


def _set_engine(builder: SceneBuilder) -> None:
    """Let Bullet compute the physics, for which the wheels are made: with others they slip, or do not turn."""
    builder.call("setInt32Param", builder.constant("intparam_dynamic_engine"), builder.constant("physics_bullet"))


def _undo_time_step(scene: CoppeliaSimScene, builder: SceneBuilder) -> Undo:
    """Return the call that lets the time step be as it is now."""
    return "setFloatParam", builder.constant("floatparam_simulation_time_step"), scene.read_time_step()


def _set_time_step(scene: CoppeliaSimScene, builder: SceneBuilder, step_s: float) -> None:
    """Let the simulation step so; raises BackendError where it does not take it."""
    parameter = builder.constant("floatparam_simulation_time_step")
    scene.connection.sim("setFloatParam", parameter, step_s, within_s=LOADING_S)
    if abs((got := scene.read_time_step()) - step_s) > _SAME * step_s:
        raise BackendError(
            f"coppeliasim: the simulation's time step was set to {step_s:g} s and is {got:g} s. "
            "Open a new scene in CoppeliaSim, or take another --rate"
        )
