"""The robot's model: a body, cameras, two driven wheels and a caster."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from drivers.mujoco.model.attributes import CollisionGroup, RenderGroup, about_z, camera_orientation, rgba
from robotcore.description import CameraDescription, Drive, MotorDescription, RobotDescription
from robotcore.description.robot import Body, Caster
from robotcore.description.urdf import BASE, CASTER_COLOUR, WHEEL_COLOUR, wheel, wheel_joint
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
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.FLOOR | CollisionGroup.THING,
        friction=SLIDING,
        priority=1,
        group=RenderGroup.ROBOT,
        rgba=rgba(body.colour),
    )


def _add_camera(base: Any, camera: CameraDescription) -> None:
    mount, seen = camera.mount, camera.intrinsics
    base.add_camera(
        name=camera.name,
        pos=[mount.x_m, mount.y_m, mount.z_m],
        quat=camera_orientation(mount),
        fovy=math.degrees(2 * math.atan(seen.height / 2 / seen.focal_length)),
        resolution=[seen.width, seen.height],
    )


ROTOR_KG_M2 = 1000.0
"""So heavy is a rotor that no wheel that clutches at it slows it down: by 0.08 N·m, less than 2e-6 of what it does."""

SOON = [0.001, 1.0]
"""solref: contacts and clutches make good at once what they miss; in two physics steps, as MuJoCo takes no less."""

HARD = [0.9999, 0.9999, 0.001, 0.5, 2.0]
"""solimp: they give way as little as MuJoCo takes. With its own figures, robots sink in and get 0.1 % less far, and a
wheel loses 0.5 % in a curve."""

_NEXT_TO_NOTHING_KG = 1e-6


def add_wheel(spec: MjSpec, base: Any, motor: MotorDescription, drive: Drive) -> None:
    """Add a wheel with its motor.

    To the floor it is a sphere: that touches at one point, on the exact track, where a cylinder rolls on either edge.
    """
    import mujoco

    radius, place = drive.wheel_radius_m, [0.0, drive.wheel_y_m(motor.name), drive.wheel_radius_m]
    rolling = _turning(base, wheel(motor.name), wheel_joint(motor.name), place)
    rolling.mass, rolling.inertia = drive.wheel_mass_kg, drive.wheel_moments_kg_m2
    _add_ball(rolling, radius, friction=[1.0, 0.0, 0.0], priority=1, group=RenderGroup.TOUCHED_ROBOT)
    rolling.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, drive.wheel_width_m / 2, 0.0],
        quat=[math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0],
        mass=0,
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.NOTHING,
        group=RenderGroup.ROBOT,
        rgba=rgba(WHEEL_COLOUR),
    )
    _add_motor(spec, base, motor)


def add_caster(base: Any, caster: Caster) -> None:
    """Add a ball that slides without friction: its own counts, not the greater of the two as elsewhere."""
    place = [caster.x_m, 0.0, caster.radius_m]
    _add_ball(base, caster.radius_m, pos=place, condim=1, priority=2, group=RenderGroup.ROBOT, rgba=rgba(CASTER_COLOUR))


def _add_motor(spec: MjSpec, base: Any, motor: MotorDescription) -> None:
    """Add a rotor that turns as commanded, with the motor's lag, and a clutch that lets go at its greatest torque.

    The rotor's velocity v has, after each step of h seconds, gone 1 - exp(-h/τ) of its way to the command u: a torque
    of gain · (u - v) on it makes it so, exactly, under Euler's integration. The clutch is friction between rotor and
    wheel. That is solved for together with the floor's; a torque by the wheel's own velocity would either be too soft
    to hold it against the robot's weight in a curve, or so hard that it shakes.
    """
    import mujoco

    rotor = f"{motor.name}_rotor"
    _turning(base, rotor, rotor, [0.0, 0.0, 0.0], armature=ROTOR_KG_M2)
    step = spec.option.timestep
    gain = ROTOR_KG_M2 / step * (-math.expm1(-step / motor.lag_s) if motor.lag_s else 1.0)
    spec.add_actuator(
        name=motor.name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=rotor,
        gainprm=[gain, *[0.0] * 9],
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[0.0, 0.0, -gain, *[0.0] * 7],
        ctrllimited=True,
        ctrlrange=[-motor.max_velocity_rad_s, motor.max_velocity_rad_s],
    )
    clutch = spec.add_tendon(
        name=f"{motor.name}_clutch",
        frictionloss=motor.max_torque_nm,
        solref_friction=SOON,
        solimp_friction=HARD,
    )
    clutch.wrap_joint(wheel_joint(motor.name), 1.0)
    clutch.wrap_joint(rotor, -1.0)


def _turning(base: Any, name: str, joint: str, place: list[float], armature: float = 0.0) -> Any:
    """Add a body that turns about the axle, and weighs next to nothing.

    Its centre of mass is set: left out, MuJoCo takes the body's place on the robot for it too, and it runs out of true.
    """
    import mujoco

    body = base.add_body(name=name, pos=place)
    body.explicitinertial = True
    body.ipos = [0.0, 0.0, 0.0]
    body.mass, body.inertia = _NEXT_TO_NOTHING_KG, [_NEXT_TO_NOTHING_KG * 1e-3] * 3
    body.add_joint(name=joint, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=armature)
    return body


def _add_ball(body: Any, radius: float, **more: Any) -> None:
    """Add a sphere that meets the floor and nothing else."""
    import mujoco

    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[radius, 0.0, 0.0],
        mass=0,
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.FLOOR,
        solref=SOON,
        solimp=HARD,
        **more,
    )
