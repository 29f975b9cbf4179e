"""Writes the description of a robot, and optionally of a world, as URDF."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

from robotcore.description.drive import Caster, TwoWheelDrive
from robotcore.description.robot import RobotDescription
from robotcore.description.types import Colour
from robotcore.description.world import Box, Cylinder, WorldDescription

BASE = "base_link"
"""The name of the link of the robot's body. Its origin is on the floor under the middle of the axle."""

CASTER = "caster_link"

WHEEL_COLOUR = (25, 25, 25)
CASTER_COLOUR = (150, 150, 150)


def name_wheel_link(motor: str) -> str:
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


class _Shape(NamedTuple):
    tag: str
    """The tag of the URDF element: ``box``, ``cylinder`` or ``sphere``."""
    size: dict[str, str]
    """The attributes of the URDF element, such as ``radius``."""
    xyz: Vector = ORIGIN
    """The position of the shape's middle in the link's frame, in metres."""
    rpy: Vector = ORIGIN
    """The roll, pitch and yaw of the shape in the link's frame, in radians."""


class _Inertia(NamedTuple):
    mass: float
    """The mass in kg."""
    moments: Vector
    """The moments of inertia about x, y and z, in kg·m²."""
    centre: Vector = ORIGIN
    """The centre of mass in the link's frame, in metres."""


_TINY_MASS_KG = 1e-6
_TINY_INERTIA = _Inertia(_TINY_MASS_KG, (_TINY_MASS_KG * 1e-4,) * 3)
"""The inertia of a link without a mass in the description. With a mass of 0, some physics engines would assume 1 kg."""


def _link(name: str, inertia: _Inertia, visual: _Shape, collision: _Shape, rgb: Colour) -> ET.Element:
    element = ET.Element("link", name=name)
    element.append(_inertial(inertia))
    appearance = _geometry("visual", visual)
    material = ET.SubElement(appearance, "material", name=f"{name}_colour")
    ET.SubElement(material, "color", rgba=_format(*(part / 255 for part in rgb), 1.0))
    element.extend((appearance, _geometry("collision", collision)))
    return element


def _inertial(inertia: _Inertia) -> ET.Element:
    element = ET.Element("inertial")
    element.append(_pose(inertia.centre, ORIGIN))
    ET.SubElement(element, "mass", value=_format(inertia.mass))
    ixx, iyy, izz = map(_format, inertia.moments)
    ET.SubElement(element, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
    return element


def _joint(name: str, kind: str, parent: str, child: str, xyz: Vector, rpy: Vector = ORIGIN) -> ET.Element:
    element = ET.Element("joint", name=name, type=kind)
    element.append(_pose(xyz, rpy))
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    return element


def _geometry(role: str, shape: _Shape) -> ET.Element:
    element = ET.Element(role)
    element.append(_pose(shape.xyz, shape.rpy))
    ET.SubElement(ET.SubElement(element, "geometry"), shape.tag, shape.size)
    return element


def _pose(xyz: Vector, rpy: Vector) -> ET.Element:
    return ET.Element("origin", xyz=_format(*xyz), rpy=_format(*rpy))


def _box(x: float, y: float, z: float, xyz: Vector = ORIGIN) -> _Shape:
    return _Shape("box", {"size": _format(x, y, z)}, xyz)


def _cylinder(radius: float, length: float, xyz: Vector = ORIGIN, rpy: Vector = ORIGIN) -> _Shape:
    return _Shape("cylinder", {"radius": _format(radius), "length": _format(length)}, xyz, rpy)


def _sphere(radius: float) -> _Shape:
    return _Shape("sphere", {"radius": _format(radius)})


def _format(*values: float) -> str:
    return " ".join(f"{value:.9g}" for value in values)


_LYING = (math.pi / 2, 0.0, 0.0)


def _list_robot_parts(robot: RobotDescription) -> Iterator[ET.Element]:
    body = robot.body
    shape = _box(body.length_m, body.width_m, body.height_m, body.middle_m)
    yield _link(BASE, _Inertia(body.mass_kg, body.moments_kg_m2, body.middle_m), shape, shape, body.colour)
    if drive := robot.require_two_wheels("the format URDF"):
        for motor in robot.all_of("motor"):
            if motor.name in drive.motors:
                yield from _list_wheel_parts(motor, drive)
        if drive.caster:
            yield from _list_caster_parts(drive.caster)
    for sensor, mount in robot.mounts.items():
        element = ET.Element("link", name=sensor_link(sensor))
        element.append(_inertial(_TINY_INERTIA))
        yield element
        rpy = (0.0, mount.pitch_rad, mount.yaw_rad)
        yield _joint(f"{sensor}_mount", "fixed", BASE, sensor_link(sensor), (mount.x_m, mount.y_m, mount.z_m), rpy)


def _list_wheel_parts(motor: Any, drive: TwoWheelDrive) -> Iterator[ET.Element]:
    name, radius = name_wheel_link(motor.name), drive.wheel_radius_m
    tyre = _cylinder(radius, drive.wheel_width_m, rpy=_LYING)
    inertia = _Inertia(drive.wheel_mass_kg, drive.wheel_moments_kg_m2)
    yield _link(name, inertia, tyre, _sphere(radius), WHEEL_COLOUR)
    place = (0.0, drive.wheel_y_m(motor.name), radius)
    axle = _joint(wheel_joint(motor.name), "continuous", BASE, name, place)
    ET.SubElement(axle, "axis", xyz="0 1 0")
    ET.SubElement(axle, "limit", effort=_format(motor.max_torque_nm), velocity=_format(motor.max_velocity_rad_s))
    yield axle


def _list_caster_parts(caster: Caster) -> Iterator[ET.Element]:
    ball = _sphere(caster.radius_m)
    moment = 0.4 * _TINY_MASS_KG * caster.radius_m**2
    yield _link(CASTER, _Inertia(_TINY_MASS_KG, (moment,) * 3), ball, ball, CASTER_COLOUR)
    yield _joint(f"{CASTER}_place", "fixed", BASE, CASTER, (caster.x_m, 0.0, caster.radius_m))


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
    ground = _box(GROUND_M, GROUND_M, _GROUND_DEPTH_M, (0.0, 0.0, -_GROUND_DEPTH_M / 2))
    yield from _list_fixed_parts(FLOOR, ground, world.floor.colour, ORIGIN, 0.0)
    for prism in world.prisms:
        place = (prism.x_m, prism.y_m, 0.0)
        yield from _list_fixed_parts(f"{prism.name}{_THING}", _make_shape(prism), prism.colour, place, prism.yaw_rad)
    for ball in world.targets:
        place = (ball.x_m, ball.y_m, ball.radius_m)
        yield from _list_fixed_parts(f"{ball.name}{_THING}", _sphere(ball.radius_m), ball.colour, place, 0.0)
    start = world.start
    yield _place_joint(BASE, "floating" if is_free else "fixed", (start.x_m, start.y_m, 0.0), start.yaw_rad)


def _list_fixed_parts(name: str, shape: _Shape, rgb: Colour, xyz: Vector, yaw: float) -> Iterator[ET.Element]:
    yield _link(name, _TINY_INERTIA, shape, shape, rgb)
    yield _place_joint(name, "fixed", xyz, yaw)


def _place_joint(name: str, kind: str, xyz: Vector, yaw: float) -> ET.Element:
    return _joint(f"{name}_place", kind, WORLD, name, xyz, (0.0, 0.0, yaw))


def _make_shape(prism: Box | Cylinder) -> _Shape:
    # A cylinder is round in URDF, and the corners of its prism of 24 sides are on it.
    middle = (0.0, 0.0, prism.height_m / 2)
    if isinstance(prism, Box):
        return _box(prism.length_m, prism.width_m, prism.height_m, middle)
    return _cylinder(prism.radius_m, prism.height_m, middle)


def build_robot_urdf(description: RobotDescription, world: WorldDescription | None = None) -> str:
    """Return a robot, and optionally a world around it, as a URDF document.

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
    robot.extend([*_list_robot_parts(description)])
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"
