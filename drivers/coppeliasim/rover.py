"""The robot as objects of a scene: a body, wheels on joints, casters that slide.

What makes a robot go in Bullet as it is told: a wheel is a ball to the floor, which grips at one point, on the exact
track; the body's mass is over the axle; a caster is on either side of it, without friction, on a force sensor,
which holds it as stiffly as physics can. With its mass on one caster a robot creeps while its wheels stand.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from drivers.coppeliasim.placing import AXLE, Placement, on_floor
from drivers.coppeliasim.workshop import NOTHING, Mask, Workshop
from robotcore.description import Drive, RobotDescription
from robotcore.description.robot import Body, Caster
from robotcore.geometry import Pose

WHEEL_FORCE_NM = 2.0
TURNS_RAD = 1e5
CASTER_MASS_KG = 0.02
DARK = (30, 30, 30)


class BuiltRobot(NamedTuple):
    """The handles of a robot: its body, which is the root, and the joint that each motor and encoder sits on."""

    body: int
    joints: Mapping[str, int]
    frame: Placement
    """The robot's own frame in the body's."""


def build_robot(workshop: Workshop, robot: RobotDescription, start: Pose) -> BuiltRobot:
    """Make a robot that stands at its start; one without a drive stands still."""
    body, frame = robot.body, on_floor(start)
    centre = Placement(*body.middle_m)
    size = (body.length_m, body.width_m, body.height_m)
    root = workshop.shape("cuboid", size, frame.at(centre), body.colour, Mask.BODY, robot.name)
    workshop.mark(root, NOTHING)
    joints: dict[str, int] = {}
    if drive := robot.drive:
        workshop.let_move(root, body.mass_kg, body.moments_kg_m2, -body.centre_x_m)
        joints = _add_wheels(workshop, drive, root, frame)
        if drive.caster:
            _add_casters(workshop, drive.caster, root, frame, _room_for_casters(body))
    return BuiltRobot(root, joints, Placement(-centre.x, 0.0, -centre.z))


def _add_wheels(workshop: Workshop, drive: Drive, root: int, frame: Placement) -> dict[str, int]:
    sides = ((drive.left, drive.left_encoder, 0.5), (drive.right, drive.right_encoder, -0.5))
    joints: dict[str, int] = {}
    for motor, encoder, side in sides:
        hub = frame.at(AXLE._replace(y=side * drive.track_m, z=drive.wheel_radius_m))
        joint = _add_joint(workshop, motor, root, hub)
        _add_wheel(workshop, drive, joint, hub)
        joints |= {name: joint for name in (motor, encoder) if name}
    return joints


def _add_joint(workshop: Workshop, motor: str, root: int, hub: Placement) -> int:
    constant = workshop.constant
    joint = workshop.make("createJoint", constant("joint_revolute"), constant("jointmode_dynamic"), 0, [0.04, 0.01])
    workshop.call("setJointInterval", joint, False, [-TURNS_RAD, 2 * TURNS_RAD])  # else its angle begins anew at π
    workshop.set_int(joint, "jointintparam_dynctrlmode", constant("jointdynctrl_velocity"))
    workshop.call("setJointTargetForce", joint, WHEEL_FORCE_NM)
    workshop.call("setJointTargetVelocity", joint, 0.0)  # the API makes joints that turn
    workshop.put(joint, hub, motor, root)
    return joint


def _add_wheel(workshop: Workshop, drive: Drive, joint: int, hub: Placement) -> None:
    size = (2 * drive.wheel_radius_m,) * 3
    wheel = workshop.shape("spheroid", size, hub, DARK, Mask.WHEEL, "wheel", joint)
    workshop.let_move(wheel, drive.wheel_mass_kg, _ball_moments(drive.wheel_mass_kg, drive.wheel_radius_m))
    workshop.set_friction(wheel, 1.0)


def _add_casters(workshop: Workshop, caster: Caster, root: int, frame: Placement, room: float) -> None:
    away = min(abs(caster.x_m), room)
    for name, x in (("front_caster", away), ("rear_caster", -away)):
        place = frame.at(Placement(x, 0.0, caster.radius_m))
        sensor = workshop.make("createForceSensor", 0, [0, 1, 1, 0, 0], [0.01, 100.0, 100.0, 0, 0])
        workshop.put(sensor, place, name, root)
        ball = workshop.shape("spheroid", (2 * caster.radius_m,) * 3, place, DARK, Mask.CASTER, "ball", sensor)
        workshop.let_move(ball, CASTER_MASS_KG, _ball_moments(CASTER_MASS_KG, caster.radius_m))
        workshop.set_friction(ball, 0.0)


def _room_for_casters(body: Body) -> float:
    """Return how far ahead of the axle, and behind it, the body reaches."""
    return min(body.front_x_m, body.length_m - body.front_x_m)


def _ball_moments(mass: float, radius: float) -> tuple[float, float, float]:
    moment = 0.4 * mass * radius * radius
    return moment, moment, moment
