"""Writes the description of a robot, and optionally of a world, as URDF."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree as ET

from robotcore.description.devices import MotorDescription, Mount
from robotcore.description.robot import Body, Caster, Drive, RobotDescription
from robotcore.description.types import Colour
from robotcore.description.world import Ball, Box, Cylinder, WorldDescription

BASE = "base_link"
"""The name of the link of the robot's body. Its origin is on the floor under the middle of the axle."""

CASTER = "caster_link"

WHEEL_COLOUR = (25, 25, 25)
CASTER_COLOUR = (150, 150, 150)


def wheel_link(motor: str) -> str:
    """Return the name of the link of a motor's wheel."""
    return f"{motor}_wheel"


def wheel_joint(motor: str) -> str:
    """Return the name of the joint of a motor's wheel. The joint's angle is positive forward."""
    return f"{motor}_joint"


def sensor_link(sensor: str) -> str:
    """Return the name of the link of a sensor. The link's x axis is the direction of the sensor."""
    return f"{sensor}_frame"


Vector = tuple[float, float, float]
ORIGIN: Vector = (0.0, 0.0, 0.0)


class Shape(NamedTuple):
    """The shape of a link."""

    tag: str
    """The tag of the URDF element: ``box``, ``cylinder`` or ``sphere``."""
    size: dict[str, str]
    """The attributes of the URDF element, such as ``radius``."""
    xyz: Vector = ORIGIN
    """The position of the shape's middle in the link's frame, in metres."""
    rpy: Vector = ORIGIN
    """The roll, pitch and yaw of the shape in the link's frame, in radians."""


class Inertia(NamedTuple):
    """The mass, the centre of mass and the moments of inertia of a link."""

    mass: float
    """The mass in kg."""
    moments: Vector
    """The moments of inertia about x, y and z, in kg·m²."""
    centre: Vector = ORIGIN
    """The centre of mass in the link's frame, in metres."""


TINY_MASS_KG = 1e-6
TINY_INERTIA = Inertia(TINY_MASS_KG, (TINY_MASS_KG * 1e-4,) * 3)
"""The inertia of a link without a mass in the description. With a mass of 0, some physics engines would assume 1 kg."""


def link(name: str, inertia: Inertia, visual: Shape, collision: Shape, rgb: Colour) -> ET.Element:
    """Return a ``link`` element.

    visual, collision: the shapes for pictures and for contacts.
    rgb: the colour, from 0 to 255 each.
    """
    element = ET.Element("link", name=name)
    element.append(inertial(inertia))
    appearance = _make_geometry("visual", visual)
    material = ET.SubElement(appearance, "material", name=f"{name}_colour")
    ET.SubElement(material, "color", rgba=format_numbers(*(part / 255 for part in rgb), 1.0))
    element.extend((appearance, _make_geometry("collision", collision)))
    return element


def inertial(inertia: Inertia) -> ET.Element:
    """Return an ``inertial`` element."""
    element = ET.Element("inertial")
    element.append(_pose(inertia.centre, ORIGIN))
    ET.SubElement(element, "mass", value=format_numbers(inertia.mass))
    ixx, iyy, izz = map(format_numbers, inertia.moments)
    ET.SubElement(element, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
    return element


def joint(name: str, kind: str, parent: str, child: str, xyz: Vector, rpy: Vector = ORIGIN) -> ET.Element:
    """Return a ``joint`` element.

    kind: the type of the joint in URDF, such as ``fixed``.
    parent, child: the names of the links.
    xyz, rpy: the pose of the child in the parent's frame, in metres and radians.
    """
    element = ET.Element("joint", name=name, type=kind)
    element.append(_pose(xyz, rpy))
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    return element


def box(x: float, y: float, z: float, xyz: Vector = ORIGIN) -> Shape:
    """Return a box whose edges have the lengths x, y and z, in metres."""
    return Shape("box", {"size": format_numbers(x, y, z)}, xyz)


def cylinder(radius: float, length: float, xyz: Vector = ORIGIN, rpy: Vector = ORIGIN) -> Shape:
    """Return a cylinder along the z axis. ``radius`` and ``length`` are in metres."""
    return Shape("cylinder", {"radius": format_numbers(radius), "length": format_numbers(length)}, xyz, rpy)


def sphere(radius: float) -> Shape:
    """Return a sphere. ``radius`` is in metres."""
    return Shape("sphere", {"radius": format_numbers(radius)})


def format_numbers(*values: float) -> str:
    """Return numbers as the text of an attribute, separated by spaces."""
    return " ".join(f"{value:.9g}" for value in values)


def _make_geometry(role: str, shape: Shape) -> ET.Element:
    element = ET.Element(role)
    element.append(_pose(shape.xyz, shape.rpy))
    ET.SubElement(ET.SubElement(element, "geometry"), shape.tag, shape.size)
    return element


def _pose(xyz: Vector, rpy: Vector) -> ET.Element:
    return ET.Element("origin", xyz=format_numbers(*xyz), rpy=format_numbers(*rpy))


_LYING = (math.pi / 2, 0.0, 0.0)


def robot_parts(description: RobotDescription) -> Iterator[ET.Element]:
    """Yield the elements of all links and joints of a robot."""
    yield _body(description.body)
    yield from _wheels(description)
    if description.drive and description.drive.caster:
        yield from _caster(description.drive.caster)
    for sensor, mount in description.mounts.items():
        yield from _sensor(sensor, mount)


def _body(body: Body) -> ET.Element:
    x, y, z = body.length_m, body.width_m, body.height_m
    shape = box(x, y, z, body.middle_m)
    return link(BASE, Inertia(body.mass_kg, body.moments_kg_m2, body.middle_m), shape, shape, body.colour)


def _wheels(description: RobotDescription) -> Iterator[ET.Element]:
    if (drive := description.drive) is None:
        return
    for motor in description.all_of(MotorDescription):
        if motor.name in (drive.left, drive.right):
            yield _make_wheel(wheel_link(motor.name), drive)
            place = (0.0, drive.wheel_y_m(motor.name), drive.wheel_radius_m)
            axle = joint(wheel_joint(motor.name), "continuous", BASE, wheel_link(motor.name), place)
            ET.SubElement(axle, "axis", xyz="0 1 0")
            limits = {"effort": motor.max_torque_nm, "velocity": motor.max_velocity_rad_s}
            ET.SubElement(axle, "limit", {key: format_numbers(value) for key, value in limits.items()})
            yield axle


def _make_wheel(name: str, drive: Drive) -> ET.Element:
    tyre = cylinder(drive.wheel_radius_m, drive.wheel_width_m, rpy=_LYING)
    inertia = Inertia(drive.wheel_mass_kg, drive.wheel_moments_kg_m2)
    return link(name, inertia, tyre, sphere(drive.wheel_radius_m), WHEEL_COLOUR)


def _caster(caster: Caster) -> Iterator[ET.Element]:
    ball = sphere(caster.radius_m)
    moment = 0.4 * TINY_MASS_KG * caster.radius_m**2
    yield link(CASTER, Inertia(TINY_MASS_KG, (moment,) * 3), ball, ball, CASTER_COLOUR)
    yield joint(f"{CASTER}_place", "fixed", BASE, CASTER, (caster.x_m, 0.0, caster.radius_m))


def _sensor(sensor: str, mount: Mount) -> Iterator[ET.Element]:
    element = ET.Element("link", name=sensor_link(sensor))
    element.append(inertial(TINY_INERTIA))
    yield element
    rpy = (0.0, mount.pitch_rad, mount.yaw_rad)
    yield joint(f"{sensor}_mount", "fixed", BASE, sensor_link(sensor), (mount.x_m, mount.y_m, mount.z_m), rpy)


WORLD = "world"
"""The name of the root link. For tools, this name means that the link is fixed."""

FLOOR = "floor"
GROUND_M = 100.0
"""The length of the ground's sides in metres. The ground continues beyond the floor's edge."""

_GROUND_DEPTH_M = 0.1


def world_parts(world: WorldDescription, robot: str, *, is_free: bool) -> Iterator[ET.Element]:
    """Yield the elements of all links and joints of a world, and of the joint between the world and the robot.

    world: the world.
    robot: the name of the robot's root link.
    is_free: whether the robot can move. Then its joint is floating, and otherwise fixed.
    """
    yield ET.Element("link", name=WORLD)
    ground = box(GROUND_M, GROUND_M, _GROUND_DEPTH_M, (0.0, 0.0, -_GROUND_DEPTH_M / 2))
    yield from _make_fixed(FLOOR, ground, world.floor.colour, ORIGIN, 0.0)
    for prism in world.prisms:
        yield from _make_fixed(
            _body_link(prism.name), _make_shape(prism), prism.colour, (prism.x_m, prism.y_m, 0.0), prism.yaw_rad
        )
    for ball in world.targets:
        yield from _make_fixed(_body_link(ball.name), sphere(ball.radius_m), ball.colour, _middle(ball), 0.0)
    start = world.start
    yield _place_joint(robot, "floating" if is_free else "fixed", (start.x_m, start.y_m, 0.0), start.yaw_rad)


def _make_fixed(name: str, shape: Shape, rgb: Colour, xyz: Vector, yaw: float) -> Iterator[ET.Element]:
    yield link(name, TINY_INERTIA, shape, shape, rgb)
    yield _place_joint(name, "fixed", xyz, yaw)


def _place_joint(name: str, kind: str, xyz: Vector, yaw: float) -> ET.Element:
    return joint(f"{name}_place", kind, WORLD, name, xyz, (0.0, 0.0, yaw))


def _make_shape(prism: Box | Cylinder) -> Shape:
    # A cylinder is round in URDF, and the corners of its prism of 24 sides are on it.
    middle = (0.0, 0.0, prism.height_m / 2)
    if isinstance(prism, Box):
        return box(prism.length_m, prism.width_m, prism.height_m, middle)
    return cylinder(prism.radius_m, prism.height_m, middle)


def _middle(ball: Ball) -> Vector:
    return ball.x_m, ball.y_m, ball.radius_m


def _body_link(thing: str) -> str:
    # This ending differs from those of the names of a robot's links.
    return f"{thing}_thing"


__all__ = ["robot_urdf"]


def robot_urdf(description: RobotDescription, world: WorldDescription | None = None) -> str:
    """Return a robot, and optionally a world around it, as a URDF document.

    The collision shape of a wheel is a sphere, which touches the floor at one point in the middle of the wheel. URDF
    has neither textures nor friction. In a simulator, set the friction coefficient of the caster to 0, and that of the
    wheels to 1.

    >>> from robotcore.description import load_robot
    >>> robot_urdf(load_robot("lookout")).splitlines()[1]
    '<robot name="lookout">'
    """
    name = f"{description.name} in {world.name}" if world else description.name
    robot = ET.Element("robot", name=name)
    robot.extend(world_parts(world, BASE, is_free=description.drive is not None) if world else ())
    robot.extend(robot_parts(description))
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"
