"""The robot in the MuJoCo model: a body, cameras, two driven wheels and a caster."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from drivers.mujoco.model.attributes import CollisionGroup, RenderGroup, camera_orientation, rgba, rotation_about_z
from robotcore.description import Caster, RobotDescription, TwoWheelDrive
from robotcore.description.robot import Body
from robotcore.description.urdf import BASE, CASTER_COLOUR, WHEEL_COLOUR, name_wheel_link, wheel_joint
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

    start: the pose of the robot's frame, whose origin is on the floor under the middle of the axle. None is the origin
        of the world.
    """
    pose = start or Pose(0.0, 0.0, 0.0)
    base = spec.worldbody.add_body(name=BASE, pos=[pose.x, pose.y, START_HEIGHT_M], quat=rotation_about_z(pose.heading))
    if description.drive:
        base.add_freejoint(name="free")
    _add_body(base, description.body)
    if drive := description.require_two_wheels("MuJoCo"):
        for motor in description.all_of(MotorDescription):
            if motor.name in drive.motors:
                add_wheel(spec, base, motor, drive)
        if drive.caster:
            add_caster(base, drive.caster)
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


ROTOR_KG_M2 = 1000.0
"""The inertia of a rotor, in kg·m². It is so great that the torque of the clutch does not slow the rotor down.

A torque of 0.08 N·m changes the velocity of the rotor by less than 2e-6 of the velocity.
"""

STIFF_SOLREF = [0.001, 1.0]
"""MuJoCo's ``solref`` of contacts and clutches: the time constant in seconds, and the damping ratio.

MuJoCo raises the time constant to its minimum, two physics steps.
"""

STIFF_SOLIMP = [0.9999, 0.9999, 0.001, 0.5, 2.0]
"""MuJoCo's ``solimp`` of contacts and clutches: the hardest values that MuJoCo accepts.

With MuJoCo's defaults, robots would sink into the floor and drive 0.1 % less far. A wheel would be 0.5 % too slow in a
curve.
"""

_NEGLIGIBLE_KG = 1e-6


def add_wheel(spec: MjSpec, base: Any, motor: MotorDescription, drive: TwoWheelDrive) -> None:
    """Add a wheel and its motor to the model.

    The collision geom of the wheel is a sphere. It touches the floor at one point, at the exact track width. A cylinder
    would roll on one of its edges.
    """
    import mujoco

    radius, place = drive.wheel_radius_m, [0.0, drive.wheel_y_m(motor.name), drive.wheel_radius_m]
    body = _add_hinged_body(base, name_wheel_link(motor.name), wheel_joint(motor.name), place)
    body.mass, body.inertia = drive.wheel_mass_kg, drive.wheel_moments_kg_m2
    _add_ball(body, radius, friction=[1.0, 0.0, 0.0], priority=1, group=RenderGroup.ROBOT_COLLISION)
    body.add_geom(
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
    """Add a ball that slides without friction. Its geom has priority, so MuJoCo ignores the floor's friction."""
    place = [caster.x_m, 0.0, caster.radius_m]
    _add_ball(base, caster.radius_m, pos=place, condim=1, priority=2, group=RenderGroup.ROBOT, rgba=rgba(CASTER_COLOUR))


def _add_motor(spec: MjSpec, base: Any, motor: MotorDescription) -> None:
    """Add the motor of a wheel: a rotor with the motor's lag, and a clutch that slips at the motor's maximum torque.

    In a step of h seconds, a lag τ reduces the difference between the command u and the velocity v of the rotor by the
    fraction 1 - exp(-h/τ). With Euler's integrator, a torque of gain · (u - v) has exactly this effect. The clutch is
    a friction between rotor and wheel, which the solver computes together with the friction of the floor. A torque
    computed from the velocity of the wheel would be too weak to hold the velocity in a curve, or so strong that the
    wheel shakes.
    """
    import mujoco

    rotor = f"{motor.name}_rotor"
    _add_hinged_body(base, rotor, rotor, [0.0, 0.0, 0.0], armature=ROTOR_KG_M2)
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
        solref_friction=STIFF_SOLREF,
        solimp_friction=STIFF_SOLIMP,
    )
    clutch.wrap_joint(wheel_joint(motor.name), 1.0)
    clutch.wrap_joint(rotor, -1.0)


def _add_hinged_body(base: Any, name: str, joint: str, place: list[float], armature: float = 0.0) -> Any:
    """Add a body with almost no mass that turns about the axle.

    The body's centre of mass is set explicitly. MuJoCo's default is off the axle.
    """
    import mujoco

    body = base.add_body(name=name, pos=place)
    body.explicitinertial = True
    body.ipos = [0.0, 0.0, 0.0]
    body.mass, body.inertia = _NEGLIGIBLE_KG, [_NEGLIGIBLE_KG * 1e-3] * 3
    body.add_joint(name=joint, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=armature)
    return body


def _add_ball(body: Any, radius: float, **more: Any) -> None:
    import mujoco

    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[radius, 0.0, 0.0],
        mass=0,
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.FLOOR,
        solref=STIFF_SOLREF,
        solimp=STIFF_SOLIMP,
        **more,
    )
