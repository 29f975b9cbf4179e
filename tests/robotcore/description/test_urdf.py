from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from robotcore.description import WorldDescription, load_robot, load_world
from robotcore.description.urdf import build_robot_urdf, is_sliding
from tests.robotcore.description import files

ARENA = load_world("arena")
WHEELS = ("front_left", "rear_left", "front_right", "rear_right")


def parse(robot: str, world: WorldDescription | None = None) -> ET.Element:
    return ET.fromstring(build_robot_urdf(load_robot(robot), world).encode())  # noqa: S314  our own


DOCUMENT = parse("rover", ARENA)


def list_names(document: ET.Element, tag: str, attribute: str = "name") -> list[str]:
    return [element.attrib[attribute] for element in document.iter(tag) if attribute in element.attrib]


def read_numbers(element: ET.Element | None, attribute: str) -> list[float]:
    assert element is not None
    return [float(number) for number in element.attrib[attribute].split()]


def find(document: ET.Element, tag: str, name: str) -> ET.Element:
    return next(element for element in document.iter(tag) if element.get("name") == name)


@pytest.mark.parametrize("world, root", [(None, "base_link"), (ARENA, "world")], ids=["robot", "world"])
@pytest.mark.parametrize("robot", ["rover", "lookout", "freenove-4wd", "picar"])
def test_links_are_a_tree_with_one_root(robot: str, world: WorldDescription | None, root: str) -> None:
    document = parse(robot, world)
    links, joints = list_names(document, "link"), list_names(document, "joint")
    children = list_names(document, "child", "link")
    assert (len(set(links)), len(set(children)), len(set(joints))) == (len(links), len(children), len(joints))
    assert set(links) - set(children) == {root}
    assert set(list_names(document, "parent", "link")) <= set(links)


def test_names_of_a_file_do_not_collide_with_names_of_links(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(files.ROVER.replace("left_motor", "caster"))
    named = ARENA.model_copy(update={"obstacles": (ARENA.obstacles[0].model_copy(update={"name": "base_link"}),)})
    document = parse(str(file), named)
    assert "caster_joint" in list_names(document, "joint")
    for tag in ("link", "joint"):
        assert len(set(list_names(document, tag))) == len(list_names(document, tag))


def test_elements_that_other_programs_reject_are_absent() -> None:
    assert [child.tag for child in find(DOCUMENT, "link", "base_link")] == ["inertial", "visual", "collision"]
    assert all(float(mass.attrib["value"]) > 0 for mass in DOCUMENT.iter("mass"))
    for inertia in DOCUMENT.iter("inertia"):
        x, y, z = sorted(float(inertia.attrib[axis]) for axis in ("ixx", "iyy", "izz"))
        assert 0 < x <= y <= z <= x + y
    materials = list_names(DOCUMENT, "material")
    assert len(set(materials)) == len(materials)


def test_a_wheel_touches_the_floor_as_a_sphere_and_looks_like_a_cylinder_on_its_side() -> None:
    wheel = find(DOCUMENT, "link", "left_motor_wheel")
    assert read_numbers(wheel.find("collision/geometry/sphere"), "radius") == [0.0325]
    assert read_numbers(wheel.find("visual/geometry/cylinder"), "length") == [0.026]
    assert read_numbers(wheel.find("visual/origin"), "rpy")[0] == pytest.approx(1.5707963)


def test_every_wheel_of_a_drive_that_skids_is_at_its_place() -> None:
    document = parse("freenove-4wd")
    places = {
        name: read_numbers(find(document, "joint", f"{name}_motor_joint").find("origin"), "xyz") for name in WHEELS
    }
    assert places == {
        "front_left": [0.06, 0.0675, 0.0325],
        "rear_left": [-0.06, 0.0675, 0.0325],
        "front_right": [0.06, -0.0675, 0.0325],
        "rear_right": [-0.06, -0.0675, 0.0325],
    }


def test_a_simulated_robot_that_skids_rolls_at_its_effective_track_and_slides_on_its_supports() -> None:
    text = build_robot_urdf(load_robot("freenove-4wd"), is_simulated=True)
    document = ET.fromstring(text.encode())  # noqa: S314  our own
    wheel = find(document, "joint", "front_right_motor_joint")
    assert read_numbers(wheel.find("origin"), "xyz") == pytest.approx([0.0, -0.0675 * 1.6, 0.0325])
    assert find(document, "link", "front_right_motor_wheel").find("visual") is None
    support = find(document, "joint", "front_right_motor_support_place")
    assert read_numbers(support.find("origin"), "xyz") == [0.06, -0.0675, 0.0325]
    assert find(document, "link", "front_right_motor_support").find("visual") is not None
    assert [link for link in list_names(document, "link") if is_sliding(link)] == [
        f"{name}_motor_support" for name in WHEELS
    ]


def test_front_wheels_roll_on_hubs_that_steer_within_the_limits_of_the_servo() -> None:
    document = parse("picar")
    inner = math.atan(math.tan(0.5236) / (1 - 0.139 / 2 / 0.162 * math.tan(0.5236)))
    outer = math.atan(math.tan(0.5236) / (1 + 0.139 / 2 / 0.162 * math.tan(0.5236)))
    for side, y, upper, lower in (("left", 0.0695, inner, -outer), ("right", -0.0695, outer, -inner)):
        steering = find(document, "joint", f"front_{side}_steering")
        assert read_numbers(steering.find("origin"), "xyz") == [0.162, y, 0.0325]
        assert read_numbers(steering.find("axis"), "xyz") == [0, 0, 1]
        limit = steering.find("limit")
        assert [*read_numbers(limit, "lower"), *read_numbers(limit, "upper")] == pytest.approx([lower, upper])
        axle = find(document, "joint", f"front_{side}_joint")
        parent = axle.find("parent")
        assert parent is not None
        assert parent.get("link") == f"front_{side}_hub"
        assert (axle.get("type"), axle.find("limit")) == ("continuous", None)


def test_bodies_wheels_and_caster_are_on_the_floor() -> None:
    for joint, radius in (("left_motor_joint", 0.0325), ("caster_link_place", 0.012), ("ball_thing_place", 0.1)):
        assert read_numbers(find(DOCUMENT, "joint", joint).find("origin"), "xyz")[2] == radius
    box, post, floor = (find(DOCUMENT, "link", name) for name in ("red-box_thing", "yellow-post_thing", "floor"))
    assert read_numbers(box.find("collision/geometry/box"), "size") == [0.5, 0.3, 0.35]
    assert read_numbers(post.find("collision/geometry/cylinder"), "length") == [0.4]
    heights = [read_numbers(each.find("collision/origin"), "xyz")[2] for each in (box, post, floor)]
    assert heights == [0.175, 0.2, -read_numbers(floor.find("collision/geometry/box"), "size")[2] / 2]


def test_the_frame_of_a_sensor_has_the_sensors_direction() -> None:
    mount = find(parse("lookout"), "joint", "eye_mount")
    assert mount.get("type") == "fixed"
    assert read_numbers(mount.find("origin"), "xyz") == [0.07, 0.0, 0.48]
    assert read_numbers(mount.find("origin"), "rpy") == [0.0, 0.2, 0.0]


def test_a_robot_without_a_drive_has_no_wheels_and_is_fixed_at_its_start() -> None:
    document = parse("lookout", ARENA)
    assert {joint.get("type") for joint in document.iter("joint")} == {"fixed"}
