"""The robot in the MuJoCo model: a body, cameras and a drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from drivers.mujoco.model.attributes import CollisionGroup, RenderGroup, camera_orientation, rgba, rotation_about_z
from drivers.mujoco.model.drive import add_drive
from robotcore.description import RobotDescription
from robotcore.description.robot import Body
from robotcore.description.urdf import BASE
from robotcore.geometry import Pose
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.motor import MotorDescription

if TYPE_CHECKING:
    from mujoco import MjSpec


BODY_FRICTION = [0.25, 0.0, 0.0]
"""The friction coefficients of the body: sliding, torsional, rolling. The first equals that of the pybullet backend.

In each step of a contact, MuJoCo pushes a sliding body away by the friction coefficient times the distance that the
body slides. With the coefficient of a wheel, a robot that slides along a wall would lose and regain contact repeatedly.
"""

START_HEIGHT_M = -1e-7
"""The start height of the robot's frame, in metres. The weight of a robot presses it into the floor by this distance.

From a height of 0, the robot would fall during the first step, and its wheels would have no grip.
"""


def add_robot(spec: MjSpec, description: RobotDescription, start: Pose | None) -> None:
    """Add a robot to the model. A robot without a drive cannot move.

    start: the pose of the robot's frame, whose origin is on the floor under the centre of the axle. None is the origin
        of the world.
    """
    pose = start or Pose(0.0, 0.0, 0.0)
    base = spec.worldbody.add_body(name=BASE, pos=[pose.x, pose.y, START_HEIGHT_M], quat=rotation_about_z(pose.heading))
    if description.drive:
        base.add_freejoint(name="free")
    _add_body(base, description.body)
    if description.drive:
        add_drive(spec, base, description.drive, description.all_of(MotorDescription))
    for camera in description.all_of(CameraDescription):
        _add_camera(base, camera)


def _add_body(base: Any, body: Body) -> None:
    """Add the mass and the collision box of the body. `Simulation` expects the box to be the first geom."""
    import mujoco

    base.explicitinertial = True
    base.mass, base.ipos, base.inertia = body.mass_kg, body.middle_m, body.moments_kg_m2
    base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[body.length_m / 2, body.width_m / 2, body.height_m / 2],
        pos=body.middle_m,
        mass=0,
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.FLOOR | CollisionGroup.THING,
        friction=BODY_FRICTION,
        priority=1,
        group=RenderGroup.ROBOT,
        rgba=rgba(body.colour),
    )


def _add_camera(base: Any, camera: CameraDescription) -> None:
    mount, intrinsics = camera.mount, camera.intrinsics
    base.add_camera(
        name=camera.name,
        pos=[mount.x_m, mount.y_m, mount.z_m],
        quat=camera_orientation(mount),
        fovy=math.degrees(2 * math.atan(intrinsics.height / 2 / intrinsics.focal_length)),
        resolution=[intrinsics.width, intrinsics.height],
    )
