from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from robotcore.description import load_robot
from robotcore.description.urdf import robot_urdf
from tests.robotcore.description import files

ROVER = load_robot("rover")
DOCUMENT = ET.fromstring(robot_urdf(ROVER).encode())  # noqa: S314  our own


def numbers(element: ET.Element | None, attribute: str) -> list[float]:
    assert element is not None
    return [float(number) for number in element.attrib[attribute].split()]


def link(name: str) -> ET.Element:
    return next(link for link in DOCUMENT.iter("link") if link.get("name") == name)


def joint(name: str) -> ET.Element:
    return next(joint for joint in DOCUMENT.iter("joint") if joint.get("name") == name)


@pytest.mark.parametrize("robot", ["rover", "lookout"])
def test_links_hang_together_as_a_tree_with_one_root(robot: str) -> None:
    document = ET.fromstring(robot_urdf(load_robot(robot)).encode())  # noqa: S314  our own
    links = [link.attrib["name"] for link in document.iter("link")]
    children = [child.attrib["link"] for child in document.iter("child")]
    assert len(set(links)) == len(links)
    assert len(set(children)) == len(children)
    assert set(links) - set(children) == {"base_link"}
    assert {parent.attrib["link"] for parent in document.iter("parent")} <= set(links)


def test_a_motor_may_be_called_caster(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(files.ROVER.replace("left_motor", "caster"))
    document = ET.fromstring(robot_urdf(load_robot(str(file))).encode())  # noqa: S314  our own
    joints = [joint.attrib["name"] for joint in document.iter("joint")]
    assert "caster_joint" in joints
    assert len(set(joints)) == len(joints)


def test_what_others_reject_is_not_there() -> None:
    order = [child.tag for child in link("base_link")]
    assert order == ["inertial", "visual", "collision"]
    for mass in DOCUMENT.iter("mass"):
        assert float(mass.attrib["value"]) > 0
    for inertia in DOCUMENT.iter("inertia"):
        x, y, z = sorted(float(inertia.attrib[axis]) for axis in ("ixx", "iyy", "izz"))
        assert 0 < x <= y <= z <= x + y
    materials = [material.attrib["name"] for material in DOCUMENT.iter("material")]
    assert len(set(materials)) == len(materials)


def test_masses_add_up_to_what_the_description_says() -> None:
    assert ROVER.drive
    total = sum(float(mass.attrib["value"]) for mass in DOCUMENT.iter("mass"))
    assert total == pytest.approx(ROVER.body.mass_kg + 2 * ROVER.drive.wheel_mass_kg, rel=1e-4)


def test_the_body_is_its_box_with_a_boxs_inertia() -> None:
    base = link("base_link")
    assert numbers(base.find("collision/geometry/box"), "size") == [0.21, 0.185, 0.11]
    assert numbers(base.find("collision/origin"), "xyz") == [0.035, 0.0, 0.073]
    assert numbers(base.find("inertial/origin"), "xyz") == [0.035, 0.0, 0.073]
    assert numbers(base.find("inertial/inertia"), "izz") == pytest.approx([1.07 / 12 * (0.21**2 + 0.185**2)])


@pytest.mark.parametrize("motor, side", [("left_motor", 1), ("right_motor", -1)])
def test_a_wheel_turns_about_the_axle_within_its_motors_limits(motor: str, side: int) -> None:
    axle = joint(f"{motor}_joint")
    assert axle.get("type") == "continuous"
    assert numbers(axle.find("axis"), "xyz") == [0, 1, 0]
    assert numbers(axle.find("origin"), "xyz") == [0, side * 0.0775, 0.0325]
    assert numbers(axle.find("limit"), "velocity") == [12.0]
    assert numbers(axle.find("limit"), "effort") == [0.08]


def test_a_wheel_touches_as_a_sphere_and_looks_like_a_cylinder_on_its_side() -> None:
    wheel = link("left_motor_wheel")
    assert numbers(wheel.find("collision/geometry/sphere"), "radius") == [0.0325]
    assert numbers(wheel.find("visual/geometry/cylinder"), "length") == [0.026]
    assert numbers(wheel.find("visual/origin"), "rpy")[0] == pytest.approx(1.5707963)


def test_wheels_and_caster_stand_on_the_floor() -> None:
    assert ROVER.drive
    assert ROVER.drive.caster
    for name, radius in (("left_motor_joint", 0.0325), ("caster_link_place", ROVER.drive.caster.radius_m)):
        assert numbers(joint(name).find("origin"), "xyz")[2] == radius


def test_every_sensor_has_a_frame_that_looks_where_it_does() -> None:
    lookout = ET.fromstring(robot_urdf(load_robot("lookout")).encode())  # noqa: S314  our own
    mount = next(joint for joint in lookout.iter("joint") if joint.get("name") == "eye_mount")
    assert mount.get("type") == "fixed"
    assert numbers(mount.find("origin"), "xyz") == [0.07, 0.0, 0.48]
    assert numbers(mount.find("origin"), "rpy") == [0.0, 0.2, 0.0]
    assert {link.attrib["name"] for link in DOCUMENT.iter("link")} >= {"nose_frame", "eye_frame"}


def test_a_robot_without_a_drive_has_no_wheels() -> None:
    assert "continuous" not in robot_urdf(load_robot("lookout"))
