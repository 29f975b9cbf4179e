"""The robot's body in Bullet. It is loaded from the robot's URDF. Other properties are set after loading."""

from __future__ import annotations

import math
from collections.abc import Iterable
from copy import copy
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from drivers.pybullet.bullet import Bullet
from drivers.pybullet.scene import CollisionGroup
from robotcore.description import RobotDescription, SkidDrive
from robotcore.description.urdf import build_robot_urdf, is_sliding, name_hub_link, name_wheel_link
from robotcore.errors import DeviceError
from robotcore.geometry import Pose, Twist

Array = NDArray[np.float64]

_BASE = -1


class Body:
    """The body of the robot in Bullet. The origin of its frame is on the floor under the centre of the axle."""

    def __init__(self, bullet: Bullet, description: RobotDescription, start: Pose) -> None:
        self._bullet = bullet
        self.body_id = _load(bullet, description, start)
        self._links = _list_links(bullet, self.body_id)
        self._drive = description.drive
        self._centre = np.array(bullet.getDynamicsInfo(self.body_id, _BASE)[3])
        self._set_up_collisions()
        self._release_free_wheels()
        if isinstance(description.drive, SkidDrive):  # their supports are drawn; Bullet would draw the wheels as balls
            self._hide(self._links[name_wheel_link(wheel.name)] for wheel in description.drive.wheels)

    def _set_up_collisions(self) -> None:
        """Let wheels and caster collide with the floor only, because the sphere of a wheel is wider than the wheel."""
        bullet, body = self._bullet, self.body_id
        bullet.setCollisionFilterGroupMask(
            body, _BASE, CollisionGroup.BODY, CollisionGroup.FLOOR | CollisionGroup.THING
        )
        for name, link in self._links.items():
            bullet.setCollisionFilterGroupMask(body, link, CollisionGroup.WHEEL, CollisionGroup.FLOOR)
            bullet.changeDynamics(body, link, lateralFriction=0.0 if is_sliding(name) else 1.0)
        # A separate call: in one call with damping, Bullet ignores the friction of a link.
        bullet.changeDynamics(body, _BASE, linearDamping=0.0, angularDamping=0.0)

    def _release_free_wheels(self) -> None:
        """Let the wheels without a motor roll freely. By default, Bullet brakes each joint."""
        bullet = self._bullet
        for wheel in self._drive.wheels if self._drive else ():
            if wheel.motor is None:
                joint = self._links[name_wheel_link(wheel.name)]
                bullet.setJointMotorControl2(self.body_id, joint, bullet.VELOCITY_CONTROL, force=0.0)

    def with_connection(self, bullet: Bullet) -> Body:
        """Return the same body with another `Bullet`, such as one whose errors name a device."""
        other = copy(self)
        other._bullet = bullet  # noqa: SLF001  its own kind
        return other

    def hide(self) -> None:
        """Make the robot invisible in all pictures."""
        self._hide((_BASE, *self._links.values()))

    def _hide(self, links: Iterable[int]) -> None:
        for link in links:
            self._bullet.changeVisualShape(self.body_id, link, rgbaColor=[0.0, 0.0, 0.0, 0.0])

    def find_joints(self, device: str) -> tuple[int, ...]:
        """Return Bullet's index of the joint of each wheel of a device.

        device: the name of a motor or an encoder. Raises DeviceError if the device is on no wheel.
        """
        wheels = self._drive.find_wheels(device) if self._drive else ()
        if not wheels:
            raise DeviceError(
                device, "the device is on no wheel. Name it in the robot's [drive], or leave it out", kind="no-wheel"
            )
        return tuple(self._links[name_wheel_link(wheel.name)] for wheel in wheels)

    def angle(self, joints: tuple[int, ...]) -> float:
        """Return the mean angle of wheels in radians. ``joints`` are indices of `find_joints`."""
        return sum(float(self._bullet.getJointState(self.body_id, joint)[0]) for joint in joints) / len(joints)

    def find_steering_joints(self) -> tuple[int, ...]:
        """Return Bullet's indices of the joints that steer the left and the right front wheel, if they are steered."""
        wheels = self._drive.wheels if self._drive else ()
        return tuple(self._links[name_hub_link(wheel.name)] for wheel in wheels if wheel.is_steered)

    def transform(self) -> tuple[Array, Array]:
        """Return the pose of the robot's frame in the world: a rotation matrix (3, 3), and an origin (3,) in metres."""
        centre, orientation = self._bullet.getBasePositionAndOrientation(self.body_id)
        rotation = np.array(self._bullet.getMatrixFromQuaternion(orientation)).reshape(3, 3)
        return rotation, np.array(centre) - rotation @ self._centre

    def pose(self) -> Pose:
        """Return the pose of the centre of the axle on the floor."""
        rotation, origin = self.transform()
        return Pose(float(origin[0]), float(origin[1]), math.atan2(rotation[1, 0], rotation[0, 0]))

    def twist(self) -> Twist:
        """Return the velocity of the centre of the axle.

        Bullet returns the velocity of the centre of mass, whose forward component is the same.
        """
        linear, angular = self._bullet.getBaseVelocity(self.body_id)
        forward = self.transform()[0][:, 0]
        return Twist(float(forward @ linear), float(angular[2]))


def _load(bullet: Bullet, description: RobotDescription, start: Pose) -> int:
    with TemporaryDirectory() as folder:
        file = Path(folder, "robot.urdf")
        file.write_text(build_robot_urdf(description, is_simulated=True), encoding="utf-8")
        number: int = bullet.loadURDF(
            str(file),
            [start.x, start.y, 0.0],
            bullet.getQuaternionFromEuler([0.0, 0.0, start.heading]),
            useFixedBase=description.drive is None,
            flags=bullet.URDF_USE_INERTIA_FROM_FILE,
        )
    return number


def _list_links(bullet: Bullet, body: int) -> dict[str, int]:
    """Return Bullet's indices of the links by name. The joint of a link has the same index."""
    return {bullet.getJointInfo(body, link)[12].decode(): link for link in range(bullet.getNumJoints(body))}
