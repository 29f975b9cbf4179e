"""The robot as objects of a scene: a body, wheels on joints, casters that slide.

A wheel is a ball to the floor: it grips at one point, on the exact track. A caster hangs on a force sensor, which holds
it as stiffly as physics can.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from drivers.coppeliasim.placing import AXLE, Placement, on_floor
from drivers.coppeliasim.workshop import Mask, Workshop
from robotcore.description import Drive, RobotDescription
from robotcore.geometry import Pose

WHEEL_FORCE_NM = 2.0
TURNS_RAD = 1e5
CASTER_MASS_KG = 0.02
WHEEL_COLOUR = CASTER_COLOUR = (30, 30, 30)


class BuiltRobot(NamedTuple):
    """The handles of a robot: its body, which is the root, and the joint that each motor and encoder sits on."""

    body: int
    joints: Mapping[str, int]
    frame: Placement
    """The robot's own frame in the body's."""


def build_robot(workshop: Workshop, robot: RobotDescription, start: Pose) -> BuiltRobot:
    """Make a robot that stands at its start; one without a drive stands still."""
    body, frame = robot.body, on_floor(start)
    centre = Placement(body.centre_x_m, 0.0, body.clearance_m + body.height_m / 2)
    size = (body.length_m, body.width_m, body.height_m)
    root = workshop.shape("cuboid", size, frame.at(centre), body.colour, Mask.BODY, robot.name)
    joints: dict[str, int] = {}
    if drive := robot.drive:
        workshop.let_move(root, body.mass_kg)
        joints = _add_wheels(workshop, drive, root, frame)
        if drive.caster:
            _add_caster(workshop, drive.caster.x_m, drive.caster.radius_m, root, frame)
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
    wheel = workshop.shape("spheroid", size, hub, WHEEL_COLOUR, Mask.WHEEL, "wheel", joint)
    workshop.let_move(wheel, drive.wheel_mass_kg)
    workshop.set_friction(wheel, 1.0)


def _add_caster(workshop: Workshop, x: float, radius: float, root: int, frame: Placement) -> None:
    place = frame.at(Placement(x, 0.0, radius))
    sensor = workshop.make("createForceSensor", 0, [0, 1, 1, 0, 0], [0.01, 100.0, 100.0, 0, 0])
    workshop.put(sensor, place, "caster", root)
    ball = workshop.shape("spheroid", (2 * radius,) * 3, place, CASTER_COLOUR, Mask.CASTER, "ball", sensor)
    workshop.let_move(ball, CASTER_MASS_KG)
    workshop.set_friction(ball, 0.0)
