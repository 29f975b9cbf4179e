"""Writes the description of a robot, and optionally of a world, as URDF."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any
from xml.etree import ElementTree as ET

from robotcore.description.drive import AckermannDrive, Caster, Drive, DriveWheel, SkidDrive, TwoWheelDrive
from robotcore.description.robot import RobotDescription
from robotcore.description.types import Colour
from robotcore.description.urdf_elements import (
    ORIGIN,
    TINY_INERTIA,
    TINY_MASS_KG,
    Inertia,
    Shape,
    Vector,
    build_frame,
    build_joint,
    build_link,
    format_numbers,
    make_box,
    make_cylinder,
    make_sphere,
)
from robotcore.description.world import Box, Cylinder, WorldDescription

BASE = "base_link"
"""The name of the link of the robot's body. Its origin is on the floor under the centre of the axle."""

CASTER = "caster_link"

STEERING_TORQUE_NM = 1.0
"""The torque of a servo that steers, in N·m. Descriptions have no torque of servos, but URDF requires one."""

WHEEL_COLOUR = (25, 25, 25)
CASTER_COLOUR = (150, 150, 150)


def name_wheel_link(wheel: str) -> str:
    """Return the name of the link of a wheel."""
    return f"{wheel}_wheel"


def wheel_joint(wheel: str) -> str:
    """Return the name of the joint of a wheel. The joint's angle is positive forward."""
    return f"{wheel}_joint"


def name_hub_link(wheel: str) -> str:
    """Return the name of the link between the body and a wheel that is steered."""
    return f"{wheel}_hub"


def steering_joint(wheel: str) -> str:
    """Return the name of the joint that steers a wheel. The joint's angle is positive to the left."""
    return f"{wheel}_steering"


_SUPPORT = "_support"

SUPPORT_GAP_M = 1e-5
"""The gap between the floor and the supports of wheels that skid, in metres. So the wheels carry the weight."""


def is_sliding(link: str) -> bool:
    """Return whether a link slides on the floor without friction: a caster, or a support of a wheel that skids."""
    return link == CASTER or link.endswith(_SUPPORT)


def locate_contact(drive: Drive, wheel: DriveWheel) -> tuple[float, float]:
    """Return x and y, in metres, of the point where a wheel touches the floor in a simulation, in the robot's frame.

    Wheels that skid touch the floor under the middle of the robot, at the effective track. There they roll, so that the
    robot turns as its description says. At the true place of each wheel is a support, which slides without friction.
    """
    if isinstance(drive, SkidDrive):
        return 0.0, math.copysign(drive.geometry.track / 2, wheel.y_m)
    return wheel.x_m, wheel.y_m


def sensor_link(sensor: str) -> str:
    """Return the name of the link of a sensor. The link's x axis is the direction of the sensor."""
    return f"{sensor}_frame"


_LYING = (math.pi / 2, 0.0, 0.0)


def _list_robot_parts(robot: RobotDescription, *, is_simulated: bool) -> Iterator[ET.Element]:
    body = robot.body
    shape = make_box(body.length_m, body.width_m, body.height_m, body.middle_m)
    yield build_link(BASE, Inertia(body.mass_kg, body.moments_kg_m2, body.middle_m), shape, shape, body.colour)
    if robot.drive:
        yield from _list_drive_parts(robot, robot.drive, is_simulated=is_simulated)
    for sensor, mount in robot.mounts.items():
        yield build_frame(sensor_link(sensor))
        rpy = (0.0, mount.pitch_rad, mount.yaw_rad)
        yield build_joint(f"{sensor}_mount", "fixed", BASE, sensor_link(sensor), (mount.x_m, mount.y_m, mount.z_m), rpy)


def _list_drive_parts(robot: RobotDescription, drive: Drive, *, is_simulated: bool) -> Iterator[ET.Element]:
    motors = {motor.name: motor for motor in robot.all_of("motor")}
    order = [*motors, None]
    for wheel in sorted(drive.wheels, key=lambda wheel: order.index(wheel.motor)):
        place = (wheel.x_m, wheel.y_m, drive.wheel_radius_m)
        if wheel.is_steered and isinstance(drive, AckermannDrive):
            yield from _list_hub_parts(robot, drive, wheel, place)
            yield from _list_wheel_parts(drive, wheel, motors, name_hub_link(wheel.name), ORIGIN, _tyre(drive))
        elif is_simulated and isinstance(drive, SkidDrive):
            contact = (*locate_contact(drive, wheel), drive.wheel_radius_m)
            yield from _list_wheel_parts(drive, wheel, motors, BASE, contact, None)
            yield from _list_support_parts(drive, wheel, place)
        else:
            yield from _list_wheel_parts(drive, wheel, motors, BASE, place, _tyre(drive))
    if isinstance(drive, TwoWheelDrive) and drive.caster:
        yield from _list_caster_parts(drive.caster)


def _list_wheel_parts(
    drive: Drive, wheel: DriveWheel, motors: Mapping[str, Any], parent: str, place: Vector, visual: Shape | None
) -> Iterator[ET.Element]:
    name, radius = name_wheel_link(wheel.name), drive.wheel_radius_m
    inertia = Inertia(drive.wheel_mass_kg, drive.wheel_moments_kg_m2)
    yield build_link(name, inertia, visual, make_sphere(radius), WHEEL_COLOUR)
    axle = build_joint(wheel_joint(wheel.name), "continuous", parent, name, place)
    ET.SubElement(axle, "axis", xyz="0 1 0")
    if wheel.motor:
        motor = motors[wheel.motor]
        torque = motor.max_torque_nm / len(drive.find_wheels(motor.name))
        ET.SubElement(axle, "limit", effort=format_numbers(torque), velocity=format_numbers(motor.max_velocity_rad_s))
    yield axle


def _list_hub_parts(
    robot: RobotDescription, drive: AckermannDrive, wheel: DriveWheel, place: Vector
) -> Iterator[ET.Element]:
    servo = next(servo for servo in robot.all_of("servo") if servo.name == drive.steering)
    limits = [drive.to_wheel_angles_rad(angle)[wheel.y_m < 0] for angle in (servo.min_angle_rad, servo.max_angle_rad)]
    hub = name_hub_link(wheel.name)
    yield build_frame(hub)
    joint = build_joint(steering_joint(wheel.name), "revolute", BASE, hub, place)
    ET.SubElement(joint, "axis", xyz="0 0 1")
    lower, upper = map(format_numbers, limits)
    effort, velocity = format_numbers(STEERING_TORQUE_NM), format_numbers(servo.max_velocity_rad_s)
    ET.SubElement(joint, "limit", lower=lower, upper=upper, effort=effort, velocity=velocity)
    yield joint


def _list_support_parts(drive: Drive, wheel: DriveWheel, place: Vector) -> Iterator[ET.Element]:
    name = f"{wheel.name}{_SUPPORT}"
    yield build_link(name, TINY_INERTIA, _tyre(drive), make_sphere(drive.wheel_radius_m - SUPPORT_GAP_M), WHEEL_COLOUR)
    yield build_joint(f"{name}_place", "fixed", BASE, name, place)


def _tyre(drive: Drive) -> Shape:
    return make_cylinder(drive.wheel_radius_m, drive.wheel_width_m, rpy=_LYING)


def _list_caster_parts(caster: Caster) -> Iterator[ET.Element]:
    ball = make_sphere(caster.radius_m)
    moment = 0.4 * TINY_MASS_KG * caster.radius_m**2
    yield build_link(CASTER, Inertia(TINY_MASS_KG, (moment,) * 3), ball, ball, CASTER_COLOUR)
    yield build_joint(f"{CASTER}_place", "fixed", BASE, CASTER, (caster.x_m, 0.0, caster.radius_m))


WORLD = "world"
"""The name of the root link. For tools, this name means that the link is fixed."""

FLOOR = "floor"
GROUND_M = 100.0
"""The length of the ground's sides in metres. The ground continues beyond the floor's edge."""

_GROUND_DEPTH_M = 0.1

_THING = "_thing"
"""The end of the names of a world's links. It differs from those of a robot's links."""


def _list_world_parts(world: WorldDescription, *, is_free: bool) -> Iterator[ET.Element]:
    """Yield the elements of all links and joints of a world, and the joint between the world and the robot.

    is_free: whether the robot can move. Then its joint is floating, and otherwise fixed.
    """
    yield ET.Element("link", name=WORLD)
    ground = make_box(GROUND_M, GROUND_M, _GROUND_DEPTH_M, (0.0, 0.0, -_GROUND_DEPTH_M / 2))
    yield from _list_fixed_parts(FLOOR, ground, world.floor.colour, ORIGIN, 0.0)
    for prism in world.prisms:
        place = (prism.x_m, prism.y_m, 0.0)
        yield from _list_fixed_parts(f"{prism.name}{_THING}", _make_shape(prism), prism.colour, place, prism.yaw_rad)
    for ball in world.targets:
        place = (ball.x_m, ball.y_m, ball.radius_m)
        yield from _list_fixed_parts(f"{ball.name}{_THING}", make_sphere(ball.radius_m), ball.colour, place, 0.0)
    start = world.start
    yield _place_joint(BASE, "floating" if is_free else "fixed", (start.x_m, start.y_m, 0.0), start.yaw_rad)


def _list_fixed_parts(name: str, shape: Shape, rgb: Colour, xyz: Vector, yaw: float) -> Iterator[ET.Element]:
    yield build_link(name, TINY_INERTIA, shape, shape, rgb)
    yield _place_joint(name, "fixed", xyz, yaw)


def _place_joint(name: str, kind: str, xyz: Vector, yaw: float) -> ET.Element:
    return build_joint(f"{name}_place", kind, WORLD, name, xyz, (0.0, 0.0, yaw))


def _make_shape(prism: Box | Cylinder) -> Shape:
    # A cylinder is round in URDF, and the corners of its prism of 24 sides are on it.
    middle = (0.0, 0.0, prism.height_m / 2)
    if isinstance(prism, Box):
        return make_box(prism.length_m, prism.width_m, prism.height_m, middle)
    return make_cylinder(prism.radius_m, prism.height_m, middle)


def build_robot_urdf(
    description: RobotDescription, world: WorldDescription | None = None, *, is_simulated: bool = False
) -> str:
    """Return a robot, and optionally a world around it, as a URDF document.

    is_simulated: whether the wheels of a drive that skids touch the floor as in robotcore's simulators, at the places
        of `locate_contact`, and not at their true places.

    The collision shape of a wheel is a sphere, which touches the floor at one point in the middle of the wheel. URDF
    has neither textures nor friction. In a simulator, set the friction coefficient of the caster to 0, and that of the
    wheels to 1.

    >>> from robotcore.description import load_robot
    >>> build_robot_urdf(load_robot("lookout")).splitlines()[1]
    '<robot name="lookout">'
    """
    name = f"{description.name} in {world.name}" if world else description.name
    robot = ET.Element("robot", name=name)
    if world:
        robot.extend([*_list_world_parts(world, is_free=description.drive is not None)])
    robot.extend(_list_robot_parts(description, is_simulated=is_simulated))
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"
