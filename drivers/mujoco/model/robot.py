"""The robot: a body on two velocity-controlled wheels and a caster, and frames for what sits on it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from drivers.mujoco.model.groups import Meets, Shown
from robotcore.description import CameraDescription, Drive, MotorDescription, RobotDescription
from robotcore.description.robot import Body, Caster, Mount
from robotcore.geometry import Pose

if TYPE_CHECKING:
    from mujoco import MjSpec

BASE = "base_link"
TOUCHED = "body"
"""The box that touches things."""

SOFTNESS = [0.0085, 1.0]
"""solref of a wheel: it hardly sinks in."""

FIRMNESS = [0.98, 0.99, 0.001, 0.5, 2.0]
"""solimp of a wheel."""

GAIN = 0.3
"""N·m for each rad/s that a wheel is too slow, up to what its motor has."""

ARMATURE = 3e-4
"""kg·m²: it takes the chatter out of a light wheel; more would be felt under the limit of the torque."""

RELEASE_M = 0.001
"""Contacts are listed from this distance on: a touch is over when the body has drawn back by as much."""

_WHEEL_RGBA = [0.1, 0.1, 0.1, 1.0]
_CASTER_RGBA = [0.6, 0.6, 0.6, 1.0]


def wheel_joint(motor: str) -> str:
    """Return the name of the joint that a motor turns."""
    return f"{motor}_joint"


def add_robot(spec: MjSpec, description: RobotDescription, start: Pose | None) -> None:
    """Add a robot, its frame on the floor under the middle of the axle; one without a drive stays where it is."""
    at = start or Pose(0.0, 0.0, 0.0)
    base = spec.worldbody.add_body(name=BASE, pos=[at.x, at.y, 0.0], quat=_about_z(at.heading))
    if description.drive:
        base.add_freejoint(name="free")
    _add_body(base, description.body)
    if drive := description.drive:
        for motor in description.all_of(MotorDescription):
            if motor.name in (drive.left, drive.right):
                _add_wheel(spec, base, motor, drive)
        if drive.caster:
            _add_caster(base, drive.caster)
    for camera in description.all_of(CameraDescription):
        _add_camera(base, camera)


def _add_body(base: Any, body: Body) -> None:
    import mujoco

    x, y, z = body.length_m, body.width_m, body.height_m
    middle = [body.centre_x_m, 0.0, body.clearance_m + z / 2]
    twelfth = body.mass_kg / 12
    base.explicitinertial = True
    base.mass, base.ipos = body.mass_kg, middle
    base.inertia = [twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y)]
    base.add_geom(
        name=TOUCHED,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[x / 2, y / 2, z / 2],
        pos=middle,
        mass=0,
        contype=Meets.NOTHING,
        conaffinity=Meets.FLOOR | Meets.THING,
        margin=RELEASE_M,
        gap=RELEASE_M,
        group=Shown.ROBOT,
        rgba=[*(part / 255 for part in body.colour), 1.0],
    )


def _add_wheel(spec: MjSpec, base: Any, motor: MotorDescription, drive: Drive) -> None:
    """Add a wheel that touches the floor as a sphere does: at one point, on the exact track."""
    import mujoco

    radius, width, mass = drive.wheel_radius_m, drive.wheel_width_m, drive.wheel_mass_kg
    y = drive.track_m / 2 if motor.name == drive.left else -drive.track_m / 2
    wheel = base.add_body(name=f"{motor.name}_wheel", pos=[0.0, y, radius])
    across = mass * (3 * radius**2 + width**2) / 12
    wheel.explicitinertial = True
    wheel.mass, wheel.inertia = mass, [across, mass * radius**2 / 2, across]
    wheel.ipos = [0.0, 0.0, 0.0]  # left out, MuJoCo takes the body's own place for it, and the wheel runs out of true
    wheel.add_joint(
        name=wheel_joint(motor.name), type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=ARMATURE
    )
    wheel.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[radius, 0.0, 0.0],
        mass=0,
        contype=Meets.NOTHING,
        conaffinity=Meets.FLOOR,
        friction=[1.0, 0.0, 0.0],
        priority=1,
        solref=SOFTNESS,
        solimp=FIRMNESS,
        group=Shown.TOUCHED_ROBOT,
    )
    wheel.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, width / 2, 0.0],
        quat=[math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0],
        mass=0,
        contype=Meets.NOTHING,
        conaffinity=Meets.NOTHING,
        group=Shown.ROBOT,
        rgba=_WHEEL_RGBA,
    )
    _add_motor(spec, motor)


def _add_motor(spec: MjSpec, motor: MotorDescription) -> None:
    """Add a velocity control with the motor's lag, exact at the end of each step, and its greatest torque."""
    import mujoco

    torque, gain = motor.max_torque_nm, [0.0] * 10
    bias = list(gain)
    gain[0], bias[2] = GAIN, -GAIN
    spec.add_actuator(
        name=motor.name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=wheel_joint(motor.name),
        dyntype=mujoco.mjtDyn.mjDYN_FILTEREXACT if motor.lag_s else mujoco.mjtDyn.mjDYN_NONE,
        dynprm=[motor.lag_s or 1.0, *[0.0] * 9],
        actearly=bool(motor.lag_s),
        gainprm=gain,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=bias,
        forcelimited=True,
        forcerange=[-torque, torque],
    )


def _add_caster(base: Any, caster: Caster) -> None:
    """Add a ball that slides without friction."""
    import mujoco

    base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[caster.radius_m, 0.0, 0.0],
        pos=[caster.x_m, 0.0, caster.radius_m],
        mass=0,
        contype=Meets.NOTHING,
        conaffinity=Meets.FLOOR,
        condim=1,
        priority=2,
        solref=SOFTNESS,
        solimp=FIRMNESS,
        group=Shown.ROBOT,
        rgba=_CASTER_RGBA,
    )


def _add_camera(base: Any, camera: CameraDescription) -> None:
    mount, seen = camera.mount, camera.intrinsics
    base.add_camera(
        name=camera.name,
        pos=[mount.x_m, mount.y_m, mount.z_m],
        quat=_looking(mount),
        fovy=math.degrees(2 * math.atan(seen.height / 2 / seen.focal_length)),
    )


def _looking(mount: Mount) -> list[float]:
    """Return the quaternion of a camera, which looks along its -z with y up."""
    import mujoco
    import numpy as np

    cy, sy, cp, sp = (
        math.cos(mount.yaw_rad),
        math.sin(mount.yaw_rad),
        math.cos(mount.pitch_rad),
        math.sin(mount.pitch_rad),
    )
    right, up, back = (sy, -cy, 0.0), (sp * cy, sp * sy, cp), (-cp * cy, -cp * sy, sp)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.array((right, up, back)).T.ravel())
    return [float(part) for part in quaternion]


def _about_z(angle: float) -> list[float]:
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]
