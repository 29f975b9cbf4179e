"""Descriptions as URDF, for any tool that reads it: http://wiki.ros.org/urdf/XML.

``base_link`` has its origin on the floor under the middle of the axle. A wheel turns about ``<motor>_joint``, forward
where the angle grows, and a sensor looks along the x axis of ``<sensor>_frame``. With a world, the root is ``world``:
the ``floor`` and each ``<thing>_thing`` are fixed to it, and the robot floats at its start.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

from robotcore.description.parts import BASE
from robotcore.description.robot import RobotDescription
from robotcore.description.urdf.robot import robot_parts
from robotcore.description.urdf.world import world_parts
from robotcore.description.world import WorldDescription

__all__ = ["robot_urdf"]


def robot_urdf(description: RobotDescription, world: WorldDescription | None = None) -> str:
    """Return the robot as a URDF document, at the start of a world where there is one.

    A wheel touches the floor as a sphere does: at one point, on the exact track, where a cylinder rolls on either
    edge. URDF knows no friction: the caster slides, and wheels should grip with a coefficient of 1. Nor does it know
    patterns: every surface has its one colour.
    """
    name = f"{description.name} in {world.name}" if world else description.name
    robot = ET.Element("robot", name=name)
    robot.extend(world_parts(world, BASE, is_free=description.drive is not None) if world else ())
    robot.extend(robot_parts(description))
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"
