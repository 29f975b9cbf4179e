"""The elements that a URDF document is made of: links with a shape, joints between them."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree as ET

from robotcore.description.base import Colour

Vector = tuple[float, float, float]
ORIGIN: Vector = (0.0, 0.0, 0.0)


class Shape(NamedTuple):
    """A geometry element's tag and attributes, and where it sits in its link."""

    tag: str
    size: dict[str, str]
    xyz: Vector = ORIGIN
    rpy: Vector = ORIGIN


class Inertia(NamedTuple):
    """A mass, its principal moments of inertia, and where its centre is in its link."""

    mass: float
    moments: Vector
    centre: Vector = ORIGIN


TOKEN_MASS_KG = 1e-6
TOKEN = Inertia(TOKEN_MASS_KG, (TOKEN_MASS_KG * 1e-4,) * 3)
"""Of a link that weighs nothing by itself: some engines put 1 kg where none, or zero, is written."""


def link(name: str, inertia: Inertia, visual: Shape, collision: Shape, rgb: Colour) -> ET.Element:
    """Return a link that is seen and touched."""
    element = ET.Element("link", name=name)
    element.append(inertial(inertia))
    seen = _placed("visual", visual)
    material = ET.SubElement(seen, "material", name=f"{name}_colour")
    ET.SubElement(material, "color", rgba=numbers(*(part / 255 for part in rgb), 1.0))
    element.extend((seen, _placed("collision", collision)))
    return element


def inertial(inertia: Inertia) -> ET.Element:
    """Return what a link weighs."""
    element = ET.Element("inertial")
    element.append(_pose(inertia.centre, ORIGIN))
    ET.SubElement(element, "mass", value=numbers(inertia.mass))
    ixx, iyy, izz = map(numbers, inertia.moments)
    ET.SubElement(element, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
    return element


def joint(name: str, kind: str, parent: str, child: str, xyz: Vector, rpy: Vector = ORIGIN) -> ET.Element:
    """Return a joint that puts one link on another."""
    element = ET.Element("joint", name=name, type=kind)
    element.append(_pose(xyz, rpy))
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    return element


def box(x: float, y: float, z: float, xyz: Vector = ORIGIN) -> Shape:
    """Return a box by its edges, in metres."""
    return Shape("box", {"size": numbers(x, y, z)}, xyz)


def cylinder(radius: float, length: float, xyz: Vector = ORIGIN, rpy: Vector = ORIGIN) -> Shape:
    """Return a cylinder along z."""
    return Shape("cylinder", {"radius": numbers(radius), "length": numbers(length)}, xyz, rpy)


def sphere(radius: float) -> Shape:
    """Return a sphere."""
    return Shape("sphere", {"radius": numbers(radius)})


def numbers(*values: float) -> str:
    """Return numbers as an attribute has them."""
    return " ".join(f"{value:.9g}" for value in values)


def _placed(role: str, shape: Shape) -> ET.Element:
    element = ET.Element(role)
    element.append(_pose(shape.xyz, shape.rpy))
    ET.SubElement(ET.SubElement(element, "geometry"), shape.tag, shape.size)
    return element


def _pose(xyz: Vector, rpy: Vector) -> ET.Element:
    return ET.Element("origin", xyz=numbers(*xyz), rpy=numbers(*rpy))
