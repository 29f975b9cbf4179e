from __future__ import annotations

import math
from pathlib import Path

import pytest

from robotcore.description import AckermannDrive, SkidDrive, TwoWheelDrive, load_any, load_robot
from robotcore.hal.robot import Role
from robotcore.runtime.needs import find_devices
from tests.robotcore.description.files import ROVER, SHIPPED, find_errors, replace
from tests.texts import CheckText

SKID = SHIPPED.joinpath("robots", "freenove-4wd.toml").read_text(encoding="utf-8")
CAR = SHIPPED.joinpath("robots", "picar.toml").read_text(encoding="utf-8")
LEFT, RIGHT = "left = [", '"front_right_motor", "rear_right_motor"]'
ENCODERS = "".join(f'[[devices]]\nkind = "encoder"\nname = "{name}"\ncounts_per_turn = 20\n' for name in "abcd")
STEERING = 'steering = "steering"\n'
MOTORS = 'left = "left_motor"\nright = "right_motor"\n'
WHEELS = f'{MOTORS}left_encoder = "left_encoder"\nright_encoder = "right_encoder"\n'
ANGLES = "min_angle_rad = -0.5236  # 30 degrees\nmax_angle_rad = 0.5236"

SKID_MISTAKES = [
    ('kind = "skid"', 'kind = "tracked"', "drive.kind", "unknown-tag"),
    ('kind = "skid"\n', "", "drive", "missing-tag"),
    ("track_factor = 1.6\n", "", "drive.track_factor", "missing-key"),
    ("track_factor = 1.6", "track_factor = 0.5", "drive.track_factor", "out-of-bounds"),
    ("track_factor = 1.6", "track_faktor = 1.6", "drive.track_faktor", "unknown-key"),
    ("wheelbase_m = 0.12\n", "", "drive.wheelbase_m", "missing-key"),
    ("wheelbase_m = 0.12", "wheelbase_m = 0.3", "", "body-shorter-than-wheels"),
    ("wheel_radius_m = 0.0325", "wheel_radius_m = 0.065", "", "wheels-overlap"),
    (RIGHT, '"front_right_motor"]', "drive", "uneven-sides"),
    (RIGHT, '"front_right_motor", "front_left_motor"]', "drive", "same-motor"),
    (RIGHT, '"front_right_motor", "rear"]', "", "no-such-device"),
    (f"right = [{RIGHT}", 'right = "front_right_motor"', "drive.right", "wrong-form"),
    (LEFT, f'left_encoder = "a"\n{LEFT}', "drive", "one-encoder"),
    (LEFT, f'left_encoder = "a"\nright_encoder = ["a"]\n{LEFT}', "drive", "same-encoder"),
    (LEFT, f'left_encoder = "a"\nright_encoder = ["b", "c", "d"]\n{LEFT}', "drive", "too-many-encoders"),
    (LEFT, f'left_encoder = "a"\nright_encoder = "z"\n{LEFT}', "", "no-such-device"),
    (LEFT, f"caster = {{ x_m = 0.1, radius_m = 0.01 }}\n{LEFT}", "drive.caster", "unknown-key"),
]
CAR_MISTAKES = [
    (STEERING, "", "drive.steering", "missing-key"),
    (STEERING, 'steering = "wheel"\n', "", "no-such-device"),
    (STEERING, 'steering = "left_motor"\n', "", "no-such-device"),
    (WHEELS, "", "drive", "unclear-motors"),
    (WHEELS, 'left = "left_motor"\n', "drive", "unclear-motors"),
    (WHEELS, f'motor = "left_motor"\n{WHEELS}', "drive", "unclear-motors"),
    (WHEELS, 'left = "left_motor"\nright = "left_motor"\n', "drive", "same-motor"),
    (WHEELS, 'motor = "left_motor"\nleft_encoder = "left_encoder"\n', "drive", "encoder-without-motor"),
    (
        WHEELS,
        'left = "left_motor"\nright = "right_motor"\nencoder = "left_encoder"\n',
        "drive",
        "encoder-without-motor",
    ),
    ('right_encoder = "right_encoder"\n', "", "drive", "one-encoder"),
    ("max_angle_rad = 0.5236\n", "", "devices[steering].max_angle_rad", "missing-key"),
    (ANGLES, "min_angle_rad = -1.57\nmax_angle_rad = 1.57", "", "steering-range"),
    (ANGLES, "min_angle_rad = 0.1\nmax_angle_rad = 0.5", "", "steering-range"),
    (ANGLES, "min_angle_rad = -1.3\nmax_angle_rad = 1.3", "", "steering-range"),
    ("wheelbase_m = 0.162", "wheelbase_m = 0.3", "", "body-shorter-than-wheels"),
    ("wheelbase_m = 0.162", "wheelbase_m = 0.06", "", "wheels-overlap"),
]


def name_cases(cases: list[tuple[str, str, str, str]]) -> list[str]:
    return [f"{number} {kind}" for number, (*_, kind) in enumerate(cases)]


@pytest.mark.parametrize("old, new, key, kind", SKID_MISTAKES, ids=name_cases(SKID_MISTAKES))
def test_mistake_in_a_drive_that_skids_has_its_key_and_kind(
    tmp_path: Path, check_text: CheckText, old: str, new: str, key: str, kind: str
) -> None:
    errors = find_errors(tmp_path, replace(SKID, old, new) + ENCODERS)
    assert (key, kind) in [(error.key, error.kind) for error in errors]
    check_text("\n".join(map(str, errors)))


@pytest.mark.parametrize("old, new, key, kind", CAR_MISTAKES, ids=name_cases(CAR_MISTAKES))
def test_mistake_in_a_drive_that_steers_has_its_key_and_kind(
    tmp_path: Path, check_text: CheckText, old: str, new: str, key: str, kind: str
) -> None:
    (error,) = find_errors(tmp_path, replace(CAR, old, new))
    assert (error.key, error.kind) == (key, kind)
    check_text(error)


def test_drive_without_a_kind_is_differential(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(replace(ROVER, "[drive]", '[drive]\nkind = "differential"'))
    assert load_any(str(file)) == load_robot("rover")
    drive = load_robot("rover").drive
    assert isinstance(drive, TwoWheelDrive)
    assert drive.kind == "differential"
    assert [(wheel.name, wheel.x_m, wheel.y_m) for wheel in drive.wheels] == [
        ("left_motor", 0.0, 0.0775),
        ("right_motor", 0.0, -0.0775),
    ]


def test_mistake_in_a_drive_without_a_kind_has_the_key_of_the_file(tmp_path: Path) -> None:
    (error,) = find_errors(tmp_path, replace(ROVER, "track_m = 0.155", "track_m = 0"))
    assert error.key == "drive.track_m"


def test_drive_that_skids_turns_like_one_with_a_wider_track() -> None:
    drive = load_robot("freenove-4wd").drive
    assert isinstance(drive, SkidDrive)
    assert drive.geometry.track == pytest.approx(1.6 * 0.135)
    assert [(wheel.motor, wheel.x_m, wheel.y_m) for wheel in drive.wheels] == [
        ("front_left_motor", 0.06, 0.0675),
        ("rear_left_motor", -0.06, 0.0675),
        ("front_right_motor", 0.06, -0.0675),
        ("rear_right_motor", -0.06, -0.0675),
    ]


def test_one_motor_may_turn_both_wheels_of_a_side(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    text = replace(SKID, 'left = ["front_left_motor", "rear_left_motor"]', 'left = ["front_left_motor"]')
    text = replace(text, f"right = [{RIGHT}", 'left_encoder = "a"\nright_encoder = "b"\nright = ["front_right_motor"]')
    file.write_text(text + ENCODERS)
    drive = load_robot(str(file)).drive
    assert drive
    assert drive.motors == ("front_left_motor", "front_right_motor")
    assert [(wheel.name, wheel.x_m, wheel.encoder) for wheel in drive.wheels] == [
        ("front_left", 0.06, "a"),
        ("rear_left", -0.06, "a"),
        ("front_right", 0.06, "b"),
        ("rear_right", -0.06, "b"),
    ]
    assert {wheel.motor for wheel in drive.find_wheels("b")} == {"front_right_motor"}


def test_encoders_of_a_drive_that_skids_are_on_the_wheels_of_the_first_motors(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(replace(SKID, LEFT, f'left_encoder = "a"\nright_encoder = ["b", "c"]\n{LEFT}') + ENCODERS)
    robot = load_robot(str(file))
    assert robot.drive
    assert robot.drive.encoders == ("a", "b", "c")
    motors = {name: motor for name, motor in robot.drive.motor_by_device.items() if name in "abc"}
    assert motors == {"a": "front_left_motor", "b": "front_right_motor", "c": "rear_right_motor"}
    assert [wheel.encoder for wheel in robot.drive.wheels] == ["a", None, "b", "c"]
    assert find_devices(robot, Role.DRIVE) == {*robot.drive.motors, "a", "b", "c", "nose"}


def test_drive_that_steers_has_two_driven_and_two_steered_wheels(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(replace(CAR, WHEELS, 'motor = "left_motor"\nencoder = "left_encoder"\n'))
    for robot, motors in (
        (load_robot("picar"), ["left_motor", "right_motor"]),
        (load_robot(str(file)), ["left_motor"]),
    ):
        assert robot.drive
        assert [*robot.drive.motors] == motors
        assert [wheel.name for wheel in robot.drive.wheels if wheel.is_steered] == ["front_left", "front_right"]
        assert [wheel.motor for wheel in robot.drive.wheels if wheel.x_m == 0] == [motors[0], motors[-1]]
        assert {"steering", *motors, *robot.drive.encoders} <= find_devices(robot, Role.DRIVE)


def test_limits_of_the_servo_define_the_sharpest_turn() -> None:
    robot, rover = load_robot("picar"), load_robot("rover")
    assert robot.min_turn_radius_m == pytest.approx(0.162 / math.tan(0.5236))
    assert robot.curvatures == pytest.approx((-1 / robot.min_turn_radius_m, 1 / robot.min_turn_radius_m))
    assert rover.min_turn_radius_m == 0


@pytest.mark.parametrize("angle", [-0.5, 0.2, 0.5])
def test_axles_of_all_wheels_meet_in_the_centre_of_the_turn(angle: float) -> None:
    drive = load_robot("picar").drive
    assert isinstance(drive, AckermannDrive)
    centre = 1 / drive.to_curvature(angle)
    assert drive.to_angle_rad(1 / centre) == pytest.approx(angle)
    left, right = drive.to_wheel_angles_rad(angle)
    for side, turned in ((1, left), (-1, right)):
        assert math.tan(turned) * (centre - side * drive.track_m / 2) == pytest.approx(drive.wheelbase_m)
