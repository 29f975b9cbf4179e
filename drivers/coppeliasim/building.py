"""A scene built from descriptions: room made for it, the world, the robot with its sensors, and all of it removed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from drivers.coppeliasim.connection import LOADING_S
from drivers.coppeliasim.eyes import Eye, add_eye
from drivers.coppeliasim.placing import LOOK, Placement, mounted, on_floor
from drivers.coppeliasim.proximity import add_proximity_sensor, looks
from drivers.coppeliasim.ranging import add_fan, require_depth
from drivers.coppeliasim.rover import BuiltRobot, build_robot
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.tidying import Undo, borrow, collected, finish, hand_over, require_empty, tidy
from drivers.coppeliasim.workshop import Workshop
from drivers.coppeliasim.world import BuiltWorld, build_world
from robotcore.description import (
    AnyDevice,
    CameraDescription,
    DisplayDescription,
    RangeSensorDescription,
    WorldDescription,
)
from robotcore.errors import BackendError
from robotcore.hal.backend import Setup
from robotcore.simulation.remote_scene import State

SCREEN = (320, 240)
_SCREEN_FOV_RAD, _SCREEN_HEIGHT_M = 1.0, 3.0
_SAME = 1e-6


class Built(NamedTuple):
    """What was built: the handles of world and robot, and of the sensors by their devices' names."""

    world: BuiltWorld
    robot: BuiltRobot
    sensors: Mapping[str, int]
    has_proximity: bool
    """Whether distances come from proximity sensors; else from pictures of depth."""


def make_room(scene: CoppeliaSimScene, workshop: Workshop) -> None:
    """Remove what a program that was killed has left; raise BackendError where somebody else uses the scene."""
    if (state := scene.state()) is not State.STOPPED:
        raise BackendError(
            f"coppeliasim: a simulation of somebody's is {state.value} in the CoppeliaSim at "
            f"{scene.connection.address}. Stop it, and run again"
        )
    tidy(workshop)
    require_empty(workshop)


def leave(scene: CoppeliaSimScene, workshop: Workshop, *, keep: bool) -> None:
    """Stop, and remove what was made and give back what was changed, or hand it over where it is to be kept.

    Where the simulator is gone or hangs, that is left to whoever comes next.
    """
    if scene.connection.is_lost:
        return
    scene.stop()
    if keep:
        hand_over(workshop)
    else:
        tidy(workshop)


def build(scene: CoppeliaSimScene, workshop: Workshop, setup: Setup, world: WorldDescription) -> Built:
    """Build the world and the robot in it, in a scene that has room, and let a tick be a step of its time."""
    built_world = build_world(workshop, world)
    has_proximity = looks(workshop, scene)
    if not has_proximity and any(isinstance(told, RangeSensorDescription) for told in setup.chosen):
        require_depth(workshop, scene.connection)
    undo: list[Undo] = [_engine(workshop), _time_step(scene, workshop)]
    undo += collected(built_world.root, (built_world.seen, built_world.met))
    borrow(workshop, built_world.root, world.light, undo)
    _set_engine(workshop)
    _set_time_step(scene, workshop, 1 / setup.rate_hz)
    robot = build_robot(workshop, setup.robot, world.start.pose)
    sensors = _Sensors(workshop, robot.body, on_floor(world.start.pose), built_world, sky_of(world), has_proximity)
    handles = {told.name: handle for told in setup.chosen if (handle := sensors.add(told)) is not None}
    finish(workshop, built_world.root)
    return Built(built_world, robot, handles, has_proximity)


def sky_of(world: WorldDescription) -> float:
    """Return the grey, from 0 to 1, that is next to the sky's colour."""
    return sum(world.light.sky_colour) / 3 / 255


class _Sensors(NamedTuple):
    """Where and how sensors are added to a robot's body."""

    workshop: Workshop
    body: int
    frame: Placement
    world: BuiltWorld
    sky: float
    has_proximity: bool

    def add(self, told: AnyDevice) -> int | None:
        """Make what a device is, and return its handle; None where it is no sensor."""
        if isinstance(told, RangeSensorDescription):
            add = add_proximity_sensor if self.has_proximity else add_fan
            return add(self.workshop, told, self.body, self.frame, self.world.met)
        if isinstance(told, CameraDescription):
            size, fov = (told.width_px, told.height_px), told.horizontal_fov_rad
            eye = Eye(size, fov, empty=self.sky, seen=self.world.seen, ignored="depth")
            return add_eye(self.workshop, eye, told.name, self.frame.at(mounted(told.mount)), self.body)
        if isinstance(told, DisplayDescription):
            place = self.frame.at(LOOK._replace(z=_SCREEN_HEIGHT_M))
            return add_eye(self.workshop, Eye(SCREEN, _SCREEN_FOV_RAD), told.name, place, self.body)
        return None


def _engine(workshop: Workshop) -> Undo:
    """Return the call that lets what computes the physics be as it is now."""
    parameter = workshop.constant("intparam_dynamic_engine")
    return "setInt32Param", parameter, workshop.call("getInt32Param", parameter)


def _set_engine(workshop: Workshop) -> None:
    """Let Bullet compute the physics, for which the wheels are made: with others they slip, or do not turn."""
    workshop.call("setInt32Param", workshop.constant("intparam_dynamic_engine"), workshop.constant("physics_bullet"))


def _time_step(scene: CoppeliaSimScene, workshop: Workshop) -> Undo:
    """Return the call that lets the time step be as it is now."""
    return "setFloatParam", workshop.constant("floatparam_simulation_time_step"), scene.time_step()


def _set_time_step(scene: CoppeliaSimScene, workshop: Workshop, step_s: float) -> None:
    """Let the simulation step so; raises BackendError where it does not take it."""
    parameter = workshop.constant("floatparam_simulation_time_step")
    scene.connection.sim("setFloatParam", parameter, step_s, within_s=LOADING_S)
    if abs((got := scene.time_step()) - step_s) > _SAME * step_s:
        raise BackendError(
            f"coppeliasim: the simulation's time step was set to {step_s:g} s and is {got:g} s. "
            "Open a new scene in CoppeliaSim, or take another --rate"
        )
