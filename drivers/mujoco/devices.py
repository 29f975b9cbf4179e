"""The motors, range sensors and cameras of a robot in a MuJoCo simulation."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.mujoco.body import Body
from drivers.mujoco.model.attributes import RANGE_GROUPS, group_flags
from drivers.mujoco.model.world import visual_name
from drivers.mujoco.opengl import NoOpenGL
from drivers.mujoco.rendering import Renderer
from robotcore.description import AckermannDrive, WorldDescription
from robotcore.description.urdf import steering_joint
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.joint import Joint
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.optics import CameraView, Image
from robotcore.simulation.rigid_body import Array, BodyCamera, Locate

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class MujocoMotor(Motor):
    """A motor of a wheel. This class only sets the velocity. MuJoCo simulates the lag and the torque limit."""

    def __init__(self, model: MjModel, data: MjData, description: MotorDescription, body: Body) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        body.find_joints(self.name)
        self._controls, self._number = data.ctrl, model.actuator(self.name).id
        self._respond = description.respond

    def _apply(self, rad_s: float) -> None:
        self._controls[self._number] = self._respond(rad_s)


class Steering:
    """The front wheels of a drive that steers. They follow the joint of its servo."""

    def __init__(self, model: MjModel, data: MjData, drive: AckermannDrive, joint: Joint) -> None:
        self._drive, self._joint, self._controls = drive, joint, data.ctrl
        self._numbers = [model.actuator(steering_joint(wheel.name)).id for wheel in drive.wheels if wheel.is_steered]

    def turn(self, time: float) -> None:
        """Let the next physics step turn the wheels to the servo's angle at a time in seconds."""
        self._controls[self._numbers] = self._drive.to_wheel_angles_rad(self._joint.angle_at(time))


@cache
def _get_range_groups() -> NDArray[np.uint8]:
    return np.array(group_flags(RANGE_GROUPS), dtype=np.uint8)


def cast_rays(model: MjModel, data: MjData, start: Array, rays: Array, reach_m: float = math.inf) -> Array:
    """Return the length of each ray up to its first hit, (n,) in metres. The rays ignore the robot and the floor.

    start: the common start of the rays in the world, (3,) in metres.
    rays: the unit vectors of the rays, (n, 3).
    reach_m: the length up to which hits count, in metres.
    """
    from mujoco import mj_multiRay, mjMAXVAL

    hit, lengths = np.zeros(len(rays), dtype=np.int32), np.zeros(len(rays))
    mj_multiRay(
        model,
        data,
        start,
        rays.ravel(),
        _get_range_groups(),
        True,
        -1,
        hit,
        lengths,
        None,
        len(rays),
        min(reach_m, mjMAXVAL),
    )
    return np.where(hit >= 0, lengths, math.inf)


class MujocoCamera(BodyCamera):
    """A camera on the robot's body. Its pictures raise DeviceError if OpenGL fails."""

    def picture(self, view: CameraView) -> Image:
        try:
            return super().picture(view)
        except NoOpenGL as error:
            raise DeviceError(self.name, str(error), kind="no-opengl") from error


class CameraSet:
    """Opens the cameras of a robot. The first camera opens OpenGL, so a robot without cameras does not need OpenGL."""

    def __init__(self, model: MjModel, data: MjData, world: WorldDescription, seed: int) -> None:
        self._model, self._data, self._sky, self._seed = model, data, world.light.sky_colour, seed
        self._things = {thing.name: model.geom(visual_name(thing.name)).id for thing in (*world.prisms, *world.targets)}
        self._renderer: Renderer | None = None

    def open(self, description: CameraDescription, clock: Clock, body: Body, locate: Locate) -> MujocoCamera:
        """Open a camera. Raises DeviceError if no OpenGL library works without a screen."""
        try:
            self._renderer = self._renderer or Renderer(self._model, self._data, self._sky)
        except NoOpenGL as missing:
            raise DeviceError(description.name, str(missing), kind="no-opengl") from missing
        return MujocoCamera(description, clock, body.transform, locate, self._renderer, self._things, self._seed)

    def close(self) -> None:
        """Release OpenGL. Further calls do nothing."""
        if self._renderer:
            self._renderer.close()
