from __future__ import annotations

import math
from xml.etree import ElementTree as ET

import pytest

from robotcore.description import load_robot, load_world
from robotcore.description.urdf import robot_urdf

ARENA = load_world("arena")
DOCUMENT = ET.fromstring(robot_urdf(load_robot("rover"), ARENA).encode())  # noqa: S314  our own


def numbers(element: ET.Element | None, attribute: str) -> list[float]:
    assert element is not None
    return [float(number) for number in element.attrib[attribute].split()]


def link(name: str) -> ET.Element:
    return next(link for link in DOCUMENT.iter("link") if link.get("name") == name)


def joint_of(child: str) -> ET.Element:
    return next(joint for joint in DOCUMENT.iter("joint") if joint.find(f"child[@link='{child}']") is not None)


def test_robot_and_things_hang_together_as_a_tree_from_the_world() -> None:
    links = [link.attrib["name"] for link in DOCUMENT.iter("link")]
    children = [child.attrib["link"] for child in DOCUMENT.iter("child")]
    joints = [joint.attrib["name"] for joint in DOCUMENT.iter("joint")]
    assert (len(set(links)), len(set(children)), len(set(joints))) == (len(links), len(children), len(joints))
    assert set(links) - set(children) == {"world"}
    assert {parent.attrib["link"] for parent in DOCUMENT.iter("parent")} <= set(links)


def test_everything_in_the_world_is_a_link_where_it_stands() -> None:
    for thing in (*ARENA.prisms, *ARENA.targets):
        joint = joint_of(f"{thing.name}_thing")
        assert joint.get("type") == "fixed"
        assert numbers(joint.find("origin"), "xyz")[:2] == pytest.approx([thing.x_m, thing.y_m])
    for prism in ARENA.prisms:
        assert numbers(joint_of(f"{prism.name}_thing").find("origin"), "rpy") == pytest.approx([0, 0, prism.yaw_rad])


def test_a_box_a_cylinder_and_a_ball_stand_on_the_floor() -> None:
    box, post, ball = link("red-box_thing"), link("yellow-post_thing"), link("ball_thing")
    assert numbers(box.find("collision/geometry/box"), "size") == [0.5, 0.3, 0.35]
    assert numbers(box.find("collision/origin"), "xyz") == [0, 0, 0.175]
    assert numbers(post.find("collision/geometry/cylinder"), "length") == [0.4]
    assert numbers(post.find("collision/origin"), "xyz") == [0, 0, 0.2]
    radius = numbers(ball.find("collision/geometry/sphere"), "radius")
    assert numbers(joint_of("ball_thing").find("origin"), "xyz")[2:] == radius
    floor = numbers(link("floor").find("collision/geometry/box"), "size")
    assert numbers(link("floor").find("collision/origin"), "xyz") == [0, 0, -floor[2] / 2]


def test_the_robot_is_free_at_its_start() -> None:
    joint, start = joint_of("base_link"), ARENA.start
    assert joint.get("type") == "floating"
    assert numbers(joint.find("origin"), "xyz") == [start.x_m, start.y_m, 0]
    assert math.isclose(numbers(joint.find("origin"), "rpy")[2], start.yaw_rad, rel_tol=1e-8)


def test_a_robot_without_a_drive_is_fixed_at_its_start() -> None:
    document = robot_urdf(load_robot("lookout"), ARENA)
    assert '<joint name="base_link_place" type="fixed">' in document
    assert "floating" not in document


def test_a_thing_may_be_called_as_a_robots_link_is() -> None:
    named = ARENA.model_copy(update={"obstacles": (ARENA.obstacles[0].model_copy(update={"name": "base_link"}),)})
    document = ET.fromstring(robot_urdf(load_robot("rover"), named).encode())  # noqa: S314  our own
    links = [link.attrib["name"] for link in document.iter("link")]
    assert len(set(links)) == len(links)
