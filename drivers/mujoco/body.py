"""The body of a robot in MuJoCo: its pose, its velocity and the joints of its wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from robotcore.description import RobotDescription
from robotcore.description.urdf import BASE, wheel_joint
from robotcore.errors import DeviceError
from robotcore.geometry import Pose, Twist
from robotcore.simulation.rigid_body import Array

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class Body:
    """The body of the robot in MuJoCo. The origin of its frame is on the floor under the centre of the axle."""

    def __init__(self, model: MjModel, data: MjData, description: RobotDescription) -> None:
        self._data = data
        self.body_id = model.body(BASE).id
        self._model, self._drive = model, description.drive

    def find_joints(self, device: str) -> tuple[int, ...]:
        """Return the index, in MuJoCo's array of positions, of the joint of each wheel of a device.

        device: the name of a motor or an encoder. Raises DeviceError if the device is on no wheel.
        """
        wheels = self._drive.find_wheels(device) if self._drive else ()
        if not wheels:
            raise DeviceError(
                device, "the device is on no wheel. Name it in the robot's [drive], or leave it out", kind="no-wheel"
            )
        return tuple(int(self._model.joint(wheel_joint(wheel.name)).qposadr[0]) for wheel in wheels)

    def angle(self, joints: tuple[int, ...]) -> float:
        """Return the mean angle of wheels in radians. ``joints`` are indices of `find_joints`."""
        return sum(float(self._data.qpos[joint]) for joint in joints) / len(joints)

    def transform(self) -> tuple[Array, Array]:
        """Return the pose of the robot's frame in the world: a rotation matrix (3, 3), and an origin (3,) in metres."""
        data = self._data
        return data.xmat[self.body_id].reshape(3, 3), data.xpos[self.body_id]

    def pose(self) -> Pose:
        """Return the pose of the centre of the axle on the floor."""
        rotation, origin = self.transform()
        return Pose(float(origin[0]), float(origin[1]), math.atan2(rotation[1, 0], rotation[0, 0]))

    def twist(self) -> Twist:
        """Return the velocity of the centre of the axle."""
        if self._drive is None:
            return Twist(0.0, 0.0)
        velocity = self._data.qvel
        return Twist(float(self.transform()[0][:, 0] @ velocity[:3]), float(velocity[5]))
