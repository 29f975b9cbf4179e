"""A robot description as URDF, for any tool that reads it: http://wiki.ros.org/urdf/XML.

``base_link`` has its origin on the floor under the middle of the axle. A wheel turns about ``<motor>_joint``, forward
where the angle grows, and a sensor looks along the x axis of ``<sensor>_frame``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree as ET

from robotcore.description.robot import Body, Caster, Drive, MotorDescription, Mount, RobotDescription

BASE = "base_link"
CASTER = "caster_link"
TOKEN_MASS_KG = 1e-6
"""Of a link whose mass the body's takes in: some engines put 1 kg where none, or zero, is written."""

Vector = tuple[float, float, float]
_ORIGIN: Vector = (0.0, 0.0, 0.0)
_LYING: Vector = (1.5707963267948966, 0.0, 0.0)
_WHEEL_RGB = (25, 25, 25)
_CASTER_RGB = (150, 150, 150)


class _Shape(NamedTuple):
    """A geometry element's tag and attributes, and where it sits in its link."""

    tag: str
    size: dict[str, str]
    xyz: Vector = _ORIGIN
    rpy: Vector = _ORIGIN


class _Inertia(NamedTuple):
    """A mass, its principal moments of inertia, and where its centre is in its link."""

    mass: float
    moments: Vector
    centre: Vector = _ORIGIN


def wheel_link(motor: str) -> str:
    """Return the name of the wheel that a motor turns."""
    return f"{motor}_wheel"


def robot_urdf(description: RobotDescription) -> str:
    """Return the robot as a URDF document.

    A wheel touches the floor as a sphere does: at one point, on the exact track, where a cylinder rolls on either
    edge. URDF knows no friction: the caster slides, and wheels should grip with a coefficient of 1.
    """
    robot = ET.Element("robot", name=description.name)
    robot.append(_body(description.body))
    robot.extend(_wheels(description))
    if description.drive and description.drive.caster:
        robot.extend(_caster(description.drive.caster))
    for device in description.devices:
        if isinstance(mount := getattr(device, "mount", None), Mount):
            robot.extend(_frame(device.name, mount))
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"


def _body(body: Body) -> ET.Element:
    x, y, z = body.length_m, body.width_m, body.height_m
    middle = (body.centre_x_m, 0.0, body.clearance_m + z / 2)
    box = _Shape("box", {"size": _numbers(x, y, z)}, middle)
    twelfth = body.mass_kg / 12
    moments = (twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y))
    return _link(BASE, _Inertia(body.mass_kg, moments, middle), box, box, body.colour)


def _wheels(description: RobotDescription) -> Iterator[ET.Element]:
    if (drive := description.drive) is None:
        return
    for motor in description.all_of(MotorDescription):
        if motor.name in (drive.left, drive.right):
            y = drive.track_m / 2 if motor.name == drive.left else -drive.track_m / 2
            link = wheel_link(motor.name)
            yield _wheel(link, drive)
            joint = _joint(f"{motor.name}_joint", "continuous", link, (0.0, y, drive.wheel_radius_m))
            ET.SubElement(joint, "axis", xyz="0 1 0")
            limits = {"effort": motor.max_torque_nm, "velocity": motor.max_velocity_rad_s}
            ET.SubElement(joint, "limit", {key: _numbers(value) for key, value in limits.items()})
            yield joint


def _wheel(name: str, drive: Drive) -> ET.Element:
    radius, width, mass = drive.wheel_radius_m, drive.wheel_width_m, drive.wheel_mass_kg
    tyre = _Shape("cylinder", {"radius": _numbers(radius), "length": _numbers(width)}, rpy=_LYING)
    across = mass * (3 * radius**2 + width**2) / 12
    moments = (across, mass * radius**2 / 2, across)
    return _link(name, _Inertia(mass, moments), tyre, _sphere(radius), _WHEEL_RGB)


def _caster(caster: Caster) -> Iterator[ET.Element]:
    ball = _sphere(caster.radius_m)
    moment = 0.4 * TOKEN_MASS_KG * caster.radius_m**2
    yield _link(CASTER, _Inertia(TOKEN_MASS_KG, (moment,) * 3), ball, ball, _CASTER_RGB)
    yield _joint("caster_joint", "fixed", CASTER, (caster.x_m, 0.0, caster.radius_m))


def _frame(sensor: str, mount: Mount) -> Iterator[ET.Element]:
    link = ET.Element("link", name=f"{sensor}_frame")
    moment = TOKEN_MASS_KG * 1e-4
    link.append(_inertial(_Inertia(TOKEN_MASS_KG, (moment,) * 3)))
    yield link
    rpy = (0.0, mount.pitch_rad, mount.yaw_rad)
    yield _joint(f"{sensor}_mount", "fixed", f"{sensor}_frame", (mount.x_m, mount.y_m, mount.z_m), rpy)


def _link(name: str, inertia: _Inertia, visual: _Shape, collision: _Shape, rgb: tuple[int, int, int]) -> ET.Element:
    link = ET.Element("link", name=name)
    link.append(_inertial(inertia))
    seen = _placed("visual", visual)
    material = ET.SubElement(seen, "material", name=f"{name}_colour")
    ET.SubElement(material, "color", rgba=_numbers(*(part / 255 for part in rgb), 1.0))
    link.extend((seen, _placed("collision", collision)))
    return link


def _inertial(inertia: _Inertia) -> ET.Element:
    inertial = ET.Element("inertial")
    inertial.append(_pose(inertia.centre, _ORIGIN))
    ET.SubElement(inertial, "mass", value=_numbers(inertia.mass))
    ixx, iyy, izz = map(_numbers, inertia.moments)
    ET.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
    return inertial


def _placed(role: str, shape: _Shape) -> ET.Element:
    element = ET.Element(role)
    element.append(_pose(shape.xyz, shape.rpy))
    ET.SubElement(ET.SubElement(element, "geometry"), shape.tag, shape.size)
    return element


def _joint(name: str, kind: str, child: str, xyz: Vector, rpy: Vector = _ORIGIN) -> ET.Element:
    joint = ET.Element("joint", name=name, type=kind)
    joint.append(_pose(xyz, rpy))
    ET.SubElement(joint, "parent", link=BASE)
    ET.SubElement(joint, "child", link=child)
    return joint


def _sphere(radius: float) -> _Shape:
    return _Shape("sphere", {"radius": _numbers(radius)})


def _pose(xyz: Vector, rpy: Vector) -> ET.Element:
    return ET.Element("origin", xyz=_numbers(*xyz), rpy=_numbers(*rpy))


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.9g}" for value in values)
