"""The robot's body in Bullet: made from its URDF, with what URDF cannot say set afterwards."""

from __future__ import annotations

import math
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from robotcore.description import RobotDescription
from robotcore.description.urdf import CASTER, robot_urdf, wheel_joint
from robotcore.geometry import Pose, Twist

from drivers.pybullet.bullet import Bullet
from drivers.pybullet.scene import Group

Array = NDArray[np.float64]

_BASE = -1


class Body:
    """The robot's links. Its frame has its origin on the floor under the middle of the axle."""

    def __init__(self, bullet: Bullet, description: RobotDescription, start: Pose) -> None:
        self._bullet = bullet
        self.number = _load(bullet, description, start)
        self._links = _links(bullet, self.number)
        self._centre = np.array(bullet.getDynamicsInfo(self.number, _BASE)[3])
        for link in (_BASE, *self._links.values()):
            group, met = (Group.BODY, Group.FLOOR | Group.THING) if link == _BASE else (Group.WHEEL, Group.FLOOR)
            bullet.setCollisionFilterGroupMask(self.number, link, group, met)
            friction = 0.0 if link == self._links.get(CASTER) else 1.0
            bullet.changeDynamics(self.number, link, lateralFriction=friction, linearDamping=0.0, angularDamping=0.0)

    def hide(self) -> None:
        """Keep the robot out of its own camera's picture, and of the window's."""
        for link in (_BASE, *self._links.values()):
            self._bullet.changeVisualShape(self.number, link, rgbaColor=[0.0, 0.0, 0.0, 0.0])

    def joint_of(self, motor: str) -> int:
        """Return Bullet's number for the joint that a motor turns."""
        return self._links[wheel_joint(motor)]

    def transform(self) -> tuple[Array, Array]:
        """Return the rotation, (3, 3), and the origin, (3,), of the robot's frame in the world."""
        centre, orientation = self._bullet.getBasePositionAndOrientation(self.number)
        rotation = np.array(self._bullet.getMatrixFromQuaternion(orientation)).reshape(3, 3)
        return rotation, np.array(centre) - rotation @ self._centre

    def pose(self) -> Pose:
        """Return where the middle of the axle is, in plan."""
        rotation, origin = self.transform()
        return Pose(float(origin[0]), float(origin[1]), math.atan2(rotation[1, 0], rotation[0, 0]))

    def twist(self) -> Twist:
        """Return how the middle of the axle moves; Bullet tells how the centre of mass does."""
        linear, angular = map(np.array, self._bullet.getBaseVelocity(self.number))
        rotation, _ = self.transform()
        at_axle = linear - np.cross(angular, rotation @ self._centre)
        return Twist(float(at_axle @ rotation[:, 0]), float(angular[2]))


def _load(bullet: Bullet, description: RobotDescription, start: Pose) -> int:
    with TemporaryDirectory() as folder:
        file = Path(folder, "robot.urdf")
        file.write_text(robot_urdf(description), encoding="utf-8")
        number: int = bullet.loadURDF(
            str(file),
            [start.x, start.y, 0.0],
            bullet.getQuaternionFromEuler([0.0, 0.0, start.heading]),
            useFixedBase=description.drive is None,
            flags=bullet.URDF_USE_INERTIA_FROM_FILE,
        )
    return number


def _links(bullet: Bullet, body: int) -> dict[str, int]:
    """Return Bullet's numbers for links by the name of the link, and of the joint that holds it."""
    links = {}
    for joint in range(bullet.getNumJoints(body)):
        info = bullet.getJointInfo(body, joint)
        links[info[1].decode()] = links[info[12].decode()] = joint
    return links
