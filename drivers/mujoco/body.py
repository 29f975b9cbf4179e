"""The robot's body as it moves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotcore.description import RobotDescription
from robotcore.description.urdf import BASE, wheel_joint
from robotcore.errors import DeviceError
from robotcore.geometry import Pose, Twist

if TYPE_CHECKING:
    from mujoco import MjData, MjModel

Array = NDArray[np.float64]


class Body:
    """Its frame has its origin on the floor under the middle of the axle."""

    def __init__(self, model: MjModel, data: MjData, description: RobotDescription) -> None:
        self._data = data
        self.number = model.body(BASE).id
        self._is_free = description.drive is not None
        self._joints = _joints(model, description)

    def joint_of(self, device: str) -> int:
        """Return where in the model's positions the wheel is that a motor or an encoder sits on."""
        if device not in self._joints:
            raise DeviceError(device, "sits on no wheel; name it in the robot's drive")
        return self._joints[device]

    def angle(self, joint: int) -> float:
        """Return how far a wheel has turned, in radians."""
        return float(self._data.qpos[joint])

    def transform(self) -> tuple[Array, Array]:
        """Return the rotation, (3, 3), and the origin, (3,), of the robot's frame in the world."""
        data = self._data
        return data.xmat[self.number].reshape(3, 3), data.xpos[self.number]

    def pose(self) -> Pose:
        """Return where the middle of the axle is, in plan."""
        rotation, origin = self.transform()
        return Pose(float(origin[0]), float(origin[1]), math.atan2(rotation[1, 0], rotation[0, 0]))

    def twist(self) -> Twist:
        """Return how the middle of the axle moves."""
        if not self._is_free:
            return Twist(0.0, 0.0)
        velocity = self._data.qvel
        return Twist(float(self.transform()[0][:, 0] @ velocity[:3]), float(velocity[5]))


def _joints(model: MjModel, description: RobotDescription) -> dict[str, int]:
    if (drive := description.drive) is None:
        return {}
    return {name: int(model.joint(wheel_joint(motor)).qposadr[0]) for name, motor in drive.on_wheels.items()}
