"""The robot's links: a body, wheels, a caster, and a frame for every sensor."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree as ET

from robotcore.description.parts import BASE, CASTER, CASTER_COLOUR, WHEEL_COLOUR, frame, wheel, wheel_joint
from robotcore.description.robot import Body, Caster, Drive, MotorDescription, Mount, RobotDescription
from robotcore.description.urdf.elements import (
    TOKEN,
    TOKEN_MASS_KG,
    Inertia,
    box,
    cylinder,
    inertial,
    joint,
    link,
    numbers,
    sphere,
)

_LYING = (math.pi / 2, 0.0, 0.0)


def robot_parts(description: RobotDescription) -> Iterator[ET.Element]:
    """Yield all links and joints of a robot."""
    yield _body(description.body)
    yield from _wheels(description)
    if description.drive and description.drive.caster:
        yield from _caster(description.drive.caster)
    for sensor, mount in description.mounts.items():
        yield from _frame(sensor, mount)


def _body(body: Body) -> ET.Element:
    x, y, z = body.length_m, body.width_m, body.height_m
    shape = box(x, y, z, body.middle_m)
    return link(BASE, Inertia(body.mass_kg, body.moments_kg_m2, body.middle_m), shape, shape, body.colour)


def _wheels(description: RobotDescription) -> Iterator[ET.Element]:
    if (drive := description.drive) is None:
        return
    for motor in description.all_of(MotorDescription):
        if motor.name in (drive.left, drive.right):
            yield _wheel(wheel(motor.name), drive)
            place = (0.0, drive.wheel_y_m(motor.name), drive.wheel_radius_m)
            axle = joint(wheel_joint(motor.name), "continuous", BASE, wheel(motor.name), place)
            ET.SubElement(axle, "axis", xyz="0 1 0")
            limits = {"effort": motor.max_torque_nm, "velocity": motor.max_velocity_rad_s}
            ET.SubElement(axle, "limit", {key: numbers(value) for key, value in limits.items()})
            yield axle


def _wheel(name: str, drive: Drive) -> ET.Element:
    tyre = cylinder(drive.wheel_radius_m, drive.wheel_width_m, rpy=_LYING)
    inertia = Inertia(drive.wheel_mass_kg, drive.wheel_moments_kg_m2)
    return link(name, inertia, tyre, sphere(drive.wheel_radius_m), WHEEL_COLOUR)


def _caster(caster: Caster) -> Iterator[ET.Element]:
    ball = sphere(caster.radius_m)
    moment = 0.4 * TOKEN_MASS_KG * caster.radius_m**2
    yield link(CASTER, Inertia(TOKEN_MASS_KG, (moment,) * 3), ball, ball, CASTER_COLOUR)
    yield joint(f"{CASTER}_place", "fixed", BASE, CASTER, (caster.x_m, 0.0, caster.radius_m))


def _frame(sensor: str, mount: Mount) -> Iterator[ET.Element]:
    looking = ET.Element("link", name=frame(sensor))
    looking.append(inertial(TOKEN))
    yield looking
    rpy = (0.0, mount.pitch_rad, mount.yaw_rad)
    yield joint(f"{sensor}_mount", "fixed", BASE, frame(sensor), (mount.x_m, mount.y_m, mount.z_m), rpy)
