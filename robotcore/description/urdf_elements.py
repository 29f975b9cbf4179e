"""The XML elements of a URDF document: links, joints and shapes."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree as ET

from robotcore.description.types import Colour

Vector = tuple[float, float, float]
ORIGIN: Vector = (0.0, 0.0, 0.0)


class Shape(NamedTuple):
    """A shape that is drawn, or that collides."""

    tag: str
    """The tag of the URDF element: ``box``, ``cylinder`` or ``sphere``."""
    size: dict[str, str]
    """The attributes of the URDF element, such as ``radius``."""
    xyz: Vector = ORIGIN
    """The position of the shape's middle in the link's frame, in metres."""
    rpy: Vector = ORIGIN
    """The roll, pitch and yaw of the shape in the link's frame, in radians."""


class Inertia(NamedTuple):
    """The mass of a link and its distribution."""

    mass: float
    """The mass in kg."""
    moments: Vector
    """The moments of inertia about x, y and z, in kg·m²."""
    centre: Vector = ORIGIN
    """The centre of mass in the link's frame, in metres."""


TINY_MASS_KG = 1e-6
TINY_INERTIA = Inertia(TINY_MASS_KG, (TINY_MASS_KG * 1e-4,) * 3)
"""The inertia of a link without a mass in the description. With a mass of 0, some physics engines would assume 1 kg."""


def build_link(name: str, inertia: Inertia, visual: Shape | None, collision: Shape, rgb: Colour) -> ET.Element:
    """Return a link with an inertia and a shape.

    visual: the shape that is drawn; None for an invisible link.
    collision: the shape that collides.
    """
    element = ET.Element("link", name=name)
    element.append(_inertial(inertia))
    if visual:
        appearance = _geometry("visual", visual)
        material = ET.SubElement(appearance, "material", name=f"{name}_colour")
        ET.SubElement(material, "color", rgba=format_numbers(*(part / 255 for part in rgb), 1.0))
        element.append(appearance)
    element.append(_geometry("collision", collision))
    return element


def build_frame(name: str) -> ET.Element:
    """Return a link without a shape."""
    element = ET.Element("link", name=name)
    element.append(_inertial(TINY_INERTIA))
    return element


def _inertial(inertia: Inertia) -> ET.Element:
    element = ET.Element("inertial")
    element.append(_pose(inertia.centre, ORIGIN))
    ET.SubElement(element, "mass", value=format_numbers(inertia.mass))
    ixx, iyy, izz = map(format_numbers, inertia.moments)
    ET.SubElement(element, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
    return element


def build_joint(name: str, kind: str, parent: str, child: str, xyz: Vector, rpy: Vector = ORIGIN) -> ET.Element:
    """Return a joint.

    kind: the type of the joint in URDF, such as ``continuous``.
    xyz, rpy: the place and the orientation of the joint and of the child in the parent's frame, in metres and radians.
    """
    element = ET.Element("joint", name=name, type=kind)
    element.append(_pose(xyz, rpy))
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    return element


def _geometry(role: str, shape: Shape) -> ET.Element:
    element = ET.Element(role)
    element.append(_pose(shape.xyz, shape.rpy))
    ET.SubElement(ET.SubElement(element, "geometry"), shape.tag, shape.size)
    return element


def _pose(xyz: Vector, rpy: Vector) -> ET.Element:
    return ET.Element("origin", xyz=format_numbers(*xyz), rpy=format_numbers(*rpy))


def make_box(x: float, y: float, z: float, xyz: Vector = ORIGIN) -> Shape:
    """Return a box with these lengths and this middle, in metres."""
    return Shape("box", {"size": format_numbers(x, y, z)}, xyz)


def make_cylinder(radius: float, length: float, xyz: Vector = ORIGIN, rpy: Vector = ORIGIN) -> Shape:
    """Return a cylinder along z with this middle, turned by roll, pitch and yaw."""
    return Shape("cylinder", {"radius": format_numbers(radius), "length": format_numbers(length)}, xyz, rpy)


def make_sphere(radius: float) -> Shape:
    """Return a sphere around the origin, whose radius is in metres."""
    return Shape("sphere", {"radius": format_numbers(radius)})


def format_numbers(*values: float) -> str:
    """Return numbers with nine digits, separated by spaces."""
    return " ".join(f"{value:.9g}" for value in values)
