"""The robot: a body, what it rolls on, and its cameras."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from drivers.mujoco.model.groups import Meets, Shown
from drivers.mujoco.model.looks import rgba
from drivers.mujoco.model.rolling import add_caster, add_wheel
from drivers.mujoco.model.turned import about_z, looking
from robotcore.description import CameraDescription, MotorDescription, RobotDescription
from robotcore.description.robot import Body
from robotcore.description.urdf import BASE
from robotcore.geometry import Pose

if TYPE_CHECKING:
    from mujoco import MjSpec


SLIDING = [0.25, 0.0, 0.0]
"""Friction of the body on whatever it touches, as in Bullet. MuJoCo pushes what slides away, by friction times the way
of a step: at a wheel's grip, rubbing along a wall would be touching it over and over."""

RESTING_M = -1e-7
"""So deep its own weight presses a robot into the floor. At 0 it would fall for a step, and its wheels have no grip."""


def add_robot(spec: MjSpec, description: RobotDescription, start: Pose | None) -> None:
    """Add a robot, its frame on the floor under the middle of the axle; one without a drive stays where it is."""
    at = start or Pose(0.0, 0.0, 0.0)
    base = spec.worldbody.add_body(name=BASE, pos=[at.x, at.y, RESTING_M], quat=about_z(at.heading))
    if description.drive:
        base.add_freejoint(name="free")
    _add_body(base, description.body)
    if drive := description.drive:
        for motor in description.all_of(MotorDescription):
            if motor.name in (drive.left, drive.right):
                add_wheel(spec, base, motor, drive)
        if drive.caster:
            add_caster(base, drive.caster)
    for camera in description.all_of(CameraDescription):
        _add_camera(base, camera)


def _add_body(base: Any, body: Body) -> None:
    """Give it its weight, and the box that touches things: the first of its shapes."""
    import mujoco

    base.explicitinertial = True
    base.mass, base.ipos, base.inertia = body.mass_kg, body.middle_m, body.moments_kg_m2
    base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[body.length_m / 2, body.width_m / 2, body.height_m / 2],
        pos=body.middle_m,
        mass=0,
        contype=Meets.NOTHING,
        conaffinity=Meets.FLOOR | Meets.THING,
        friction=SLIDING,
        priority=1,
        group=Shown.ROBOT,
        rgba=rgba(body.colour),
    )


def _add_camera(base: Any, camera: CameraDescription) -> None:
    mount, seen = camera.mount, camera.intrinsics
    base.add_camera(
        name=camera.name,
        pos=[mount.x_m, mount.y_m, mount.z_m],
        quat=looking(mount),
        fovy=math.degrees(2 * math.atan(seen.height / 2 / seen.focal_length)),
        resolution=[seen.width, seen.height],
    )
