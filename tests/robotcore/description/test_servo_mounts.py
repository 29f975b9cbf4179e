"""Mounts on servos, and the mistakes of files with them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.hal.joint import Joints
from tests.robotcore.description.files import ROVER, find_errors, replace
from tests.texts import CheckText


def format_servo(name: str, mount: str = "x_m = 0.1, z_m = 0.1") -> str:
    table = f'\n[[devices]]\nkind = "servo"\nname = "{name}"\nmin_angle_rad = -3.0\nmax_angle_rad = 3.0\n'
    return table + "max_velocity_rad_s = 2.0\n" + (f"mount = {{ {mount} }}\n" if mount else "")


def put_nose_on(servo: str) -> str:
    return replace(ROVER, "mount = { x_m = 0.14, z_m = 0.10 }", f'mount = {{ x_m = 0.14, z_m = 0.10, on = "{servo}" }}')


PAN = format_servo("pan")


def load(folder: Path, text: str) -> RobotDescription:
    file = folder / "panning.toml"
    file.write_text(text)
    return load_robot(str(file))


@pytest.mark.parametrize(
    "text, key, kind",
    [
        (put_nose_on("pan"), "", "no-such-device"),
        (put_nose_on("pann") + PAN, "", "no-such-device"),
        (put_nose_on("eye"), "", "not-a-servo"),
        (put_nose_on("pan") + format_servo("pan", mount=""), "", "servo-without-mount"),
        (ROVER + format_servo("pan", 'z_m = 0.1, on = "pan"'), "", "mounts-in-circle"),
        (
            ROVER + format_servo("a", 'z_m = 0.1, on = "b"') + format_servo("b", 'z_m = 0.1, on = "a"'),
            "",
            "mounts-in-circle",
        ),
        (put_nose_on("No servo"), "devices[nose].mount.on", "no-name"),
    ],
)
def test_wrong_servo_of_a_mount_is_a_mistake(
    tmp_path: Path, check_text: CheckText, text: str, key: str, kind: str
) -> None:
    (error,) = find_errors(tmp_path, text)
    assert (error.key, error.kind) == (key, kind)
    check_text(error)


def test_device_turns_about_the_mount_of_its_servo(tmp_path: Path) -> None:
    robot = load(tmp_path, put_nose_on("pan") + PAN)
    clock = SteppedClock(20.0, lambda _steps: None)
    joints, mount = Joints(robot, clock), robot.mounts["nose"]
    assert joints.locate(mount).pose == (0.14, 0.0, 0.0)
    joints["pan"].turn_to(math.pi / 2)
    clock.sleep_until(1.0)
    assert joints.locate(mount).pose == pytest.approx((0.1, 0.04, math.pi / 2))
    assert (joints.locate(mount).z_m, joints.locate(mount).is_ahead) == (0.10, False)


def test_servo_on_a_servo_turns_with_it(tmp_path: Path) -> None:
    text = (
        put_nose_on("top")
        + format_servo("base", "z_m = 0.05")
        + format_servo("top", 'x_m = 0.1, z_m = 0.1, on = "base"')
    )
    robot = load(tmp_path, text)
    clock = SteppedClock(20.0, lambda _steps: None)
    joints = Joints(robot, clock)
    joints["base"].turn_to(math.pi / 2)
    joints["top"].turn_to(-math.pi / 2)
    clock.sleep_until(1.0)
    assert robot.list_carriers("nose") == ("top", "base")
    assert joints.locate(robot.mounts["nose"]).pose == pytest.approx((0.04, 0.1, 0.0))


def test_fixed_mount_stays_as_it_is(tmp_path: Path) -> None:
    robot = load(tmp_path, ROVER + PAN)
    mount = robot.mounts["nose"]
    assert Joints(robot, SteppedClock(20.0, lambda _steps: None)).locate(mount) is mount


def test_sensor_on_a_servo_may_point_ahead(tmp_path: Path) -> None:
    text = replace(put_nose_on("pan") + PAN, 'on = "pan"', 'yaw_rad = 1.57, on = "pan"')
    assert [sensor.name for sensor in load(tmp_path, text).sensors_ahead] == ["nose"]
