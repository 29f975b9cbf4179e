"""The drive in the MuJoCo model: wheels, motors, a steering and a caster."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from drivers.mujoco.model.attributes import CollisionGroup, RenderGroup, rgba
from robotcore.description import Caster, Drive, DriveWheel, SkidDrive, TwoWheelDrive
from robotcore.description.urdf import (
    CASTER_COLOUR,
    SUPPORT_GAP_M,
    WHEEL_COLOUR,
    locate_contact,
    name_hub_link,
    name_wheel_link,
    steering_joint,
    wheel_joint,
)
from robotcore.kinds.motor import MotorDescription

if TYPE_CHECKING:
    from mujoco import MjSpec

Place = Sequence[float]

ALONG_AXLE, UPWARD = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

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


def add_drive(spec: MjSpec, base: Any, drive: Drive, motors: Sequence[MotorDescription]) -> None:
    """Add a drive to the model of a robot.

    motors: all motors of the robot. Those of the drive are added.
    """
    for motor in motors:
        if wheels := drive.find_wheels(motor.name):
            for wheel in wheels:
                _add_wheel(base, drive, wheel, [*locate_contact(drive, wheel), drive.wheel_radius_m])
            _add_motor(spec, base, motor, wheels)
    for wheel in drive.wheels:
        if wheel.is_steered:
            _add_steered_wheel(spec, base, drive, wheel)
        elif isinstance(drive, SkidDrive):
            _add_support(base, drive, wheel)
    if isinstance(drive, TwoWheelDrive) and drive.caster:
        _add_caster(base, drive.caster)


def _add_wheel(base: Any, drive: Drive, wheel: DriveWheel, place: Place) -> None:
    """Add a wheel at a place in the frame of ``base``.

    The collision geom of the wheel is a sphere. It touches the floor at one point, at the exact track width. A cylinder
    would roll on one of its edges.
    """
    body = _add_hinged_body(base, name_wheel_link(wheel.name), wheel_joint(wheel.name), place, ALONG_AXLE)
    body.mass, body.inertia = drive.wheel_mass_kg, drive.wheel_moments_kg_m2
    _add_ball(body, drive.wheel_radius_m, friction=[1.0, 0.0, 0.0], priority=1, group=RenderGroup.ROBOT_COLLISION)
    if not isinstance(drive, SkidDrive):
        _add_tyre(body, drive, [0.0, 0.0, 0.0])


def _add_steered_wheel(spec: MjSpec, base: Any, drive: Drive, wheel: DriveWheel) -> None:
    """Add a wheel that rolls freely on a hub. An actuator turns the hub to its control, an angle, within one step."""
    import mujoco

    hub, joint = name_hub_link(wheel.name), steering_joint(wheel.name)
    place = [wheel.x_m, wheel.y_m, drive.wheel_radius_m]
    _add_wheel(_add_hinged_body(base, hub, joint, place, UPWARD, ROTOR_KG_M2), drive, wheel, [0.0, 0.0, 0.0])
    step = spec.option.timestep
    stiffness, damping = ROTOR_KG_M2 / step**2, ROTOR_KG_M2 / step
    spec.add_actuator(
        name=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=joint,
        gainprm=[stiffness, *[0.0] * 9],
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[0.0, -stiffness, -damping, *[0.0] * 7],
    )


def _add_support(base: Any, drive: Drive, wheel: DriveWheel) -> None:
    """Add the support of a wheel that skids, and its visible tyre. `locate_contact` describes supports."""
    place, radius = [wheel.x_m, wheel.y_m, drive.wheel_radius_m], drive.wheel_radius_m - SUPPORT_GAP_M
    _add_ball(base, radius, pos=place, condim=1, priority=2, group=RenderGroup.ROBOT_COLLISION)
    _add_tyre(base, drive, place)


def _add_tyre(body: Any, drive: Drive, place: Place) -> None:
    import mujoco

    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[drive.wheel_radius_m, drive.wheel_width_m / 2, 0.0],
        pos=place,
        quat=[math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0],
        mass=0,
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.NOTHING,
        group=RenderGroup.ROBOT,
        rgba=rgba(WHEEL_COLOUR),
    )


def _add_caster(base: Any, caster: Caster) -> None:
    """Add a ball that slides without friction. Its geom has priority, so MuJoCo ignores the floor's friction."""
    place = [caster.x_m, 0.0, caster.radius_m]
    _add_ball(base, caster.radius_m, pos=place, condim=1, priority=2, group=RenderGroup.ROBOT, rgba=rgba(CASTER_COLOUR))


def _add_motor(spec: MjSpec, base: Any, motor: MotorDescription, wheels: Sequence[DriveWheel]) -> None:
    """Add the motor of wheels: a rotor with the motor's lag, and a clutch that slips at the motor's maximum torque.

    In a step of h seconds, a lag τ reduces the difference between the command u and the velocity v of the rotor by the
    fraction 1 - exp(-h/τ). With Euler's integrator, a torque of gain · (u - v) has exactly this effect. The clutch is
    a friction between rotor and wheel, which the solver computes together with the friction of the floor. A torque
    computed from the velocity of the wheel would be too weak to hold the velocity in a curve, or so strong that the
    wheel shakes.
    """
    import mujoco

    rotor = f"{motor.name}_rotor"
    _add_hinged_body(base, rotor, rotor, [0.0, 0.0, 0.0], ALONG_AXLE, ROTOR_KG_M2)
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
    for wheel in wheels:
        clutch.wrap_joint(wheel_joint(wheel.name), 1 / len(wheels))
    clutch.wrap_joint(rotor, -1.0)


def _add_hinged_body(base: Any, name: str, joint: str, place: Place, axis: Place, armature: float = 0.0) -> Any:
    """Add a body with almost no mass that turns about an axis.

    The body's centre of mass is set explicitly. MuJoCo's default is off the axle.
    """
    import mujoco

    body = base.add_body(name=name, pos=place)
    body.explicitinertial = True
    body.ipos = [0.0, 0.0, 0.0]
    body.mass, body.inertia = _NEGLIGIBLE_KG, [_NEGLIGIBLE_KG * 1e-3] * 3
    body.add_joint(name=joint, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis, armature=armature)
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
