"""The motors, the steering and the rays of a robot in a MuJoCo simulation."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.mujoco.body import Body
from drivers.mujoco.model.attributes import RANGE_GROUPS, group_flags
from robotcore.description import AckermannDrive
from robotcore.description.urdf import steering_joint
from robotcore.hal.joint import Joint
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.simulation.rigid_body import Array

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
