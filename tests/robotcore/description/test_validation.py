from __future__ import annotations

from pathlib import Path

import pytest

from tests.robotcore.description.files import ARENA, ROVER, changed, errors, values

COLOUR = "[red, green, blue] from 0 to 255, or the name of a colour"


@pytest.mark.parametrize(
    "old, new, line",
    [
        (
            "length_m",
            "lenght_m",
            "body.lenght_m: is unknown. Correct it or take it out. Did you mean 'length_m'?",
        ),
        (
            'name = "nose"\nmount = { x_m',
            'name = "nose"\nmount = { x_mm',
            "devices[nose].mount.x_mm: is unknown. Correct it or take it out. Did you mean 'x_m'?",
        ),
        (
            "[safety]",
            "[pybulet]\n[safety]",
            "pybulet: is unknown. Correct it or take it out. Did you mean 'pybullet'?",
        ),
        (
            "[safety]",
            "[backends.mock]\n[safety]",
            "backends: a backend's section stands at the top. Write [NAME], not [backends.NAME]",
        ),
        ("[body]", "mock = 3\n[body]", "mock: should be a table, got 3. Correct it"),
        ("track_m = 0.155\n", "", "drive.track_m: is missing. Add it"),
        ("cone_rad", "#", "devices[nose].cone_rad: is missing. Add it"),
        (
            "width_m = 0.185",
            'width_m = "wide"',
            "body.width_m: should be a valid number, got 'wide'. Correct it",
        ),
        ("width_m = 0.185", "width_m = true", "body.width_m: should be a valid number, got true. Correct it"),
        ("width_m = 0.185", "width_m = nan", "body.width_m: should be a finite number, got nan. Correct it"),
        (
            "width_m = 0.185",
            f"width_m = 0x{'f' * 5000}",
            "body.width_m: has 20000 bits, at most 64 are read. Take a smaller number",
        ),
        ("[60, 65, 75]", "[60, 65, 256]", "body.colour[#3]: should be at most 255, got 256. Correct it"),
        ("[60, 65, 75]", "7", f"body.colour: should be {COLOUR}, got 7. Correct it"),
        ("[60, 65, 75]", "[60, 65]", f"body.colour: should be {COLOUR}, got a list of 2. Correct it"),
        ("[60, 65, 75]", "[60, 65, 7.5]", "body.colour[#3]: should be a whole number, got 7.5. Correct it"),
        ('name = "rover"', "name = 3", "name: should be a string in quotes, got 3. Correct it"),
        (
            'kind = "range_sensor"',
            'kind = "range-sensor"',
            "devices[nose].kind: 'range-sensor' is unknown. Did you mean 'range_sensor'?",
        ),
        (
            'kind = "range_sensor"\n',
            "",
            "devices[nose].kind: is missing. Add it: it says what sort of thing this is",
        ),
        (
            '"right_motor"\nmax',
            '"left_motor"\nmax',
            "two devices are named 'left_motor'. Give each a name of its own",
        ),
        (
            'name = "rover"',
            'name = "My rover"',
            "name: 'My rover' is no name. Take up to 64 lower-case letters, digits, _ and -, beginning with a letter",
        ),
        (
            "mount = { x_m = 0.14, z_m = 0.10 }",
            "mount = { z_m = -0.10 }",
            "devices[nose].mount.z_m: should be at least 0 m, got -0.1. Correct it",
        ),
        (
            'left = "left_motor"',
            'left = "right_motor"',
            "drive: left and right are both 'right_motor'. Name two motors",
        ),
        (
            'left = "left_motor"',
            'left = "port"',
            (
                "drive names the motor 'port', which is not among the devices. "
                'Add [[devices]] with kind = "motor" and that name'
            ),
        ),
        (
            'left_encoder = "left_encoder"\n',
            "",
            "drive: one wheel alone has an encoder. Name both encoders or neither",
        ),
        (
            "track_m = 0.155",
            "track_m = 0.3",
            (
                "the wheels are 0.326 m from outside to outside, the body is 0.185 m wide. "
                "Let body.width_m take in the wheels"
            ),
        ),
        (
            "wheel_radius_m = 0.0325",
            "wheel_radius_m = 32.5",
            (
                "a wheel's radius is 32.5 m, and the body with its wheels 0.21 m long. "
                "Give drive.wheel_radius_m in metres"
            ),
        ),
        (
            "track_m = 0.155",
            "track_m = 15.5",
            "drive.track_m is 15.5, and the body with its wheels 0.185 m wide. Give it in metres",
        ),
        (
            "wheel_width_m = 0.026",
            "wheel_width_m = 26",
            "drive.wheel_width_m is 26, and the body with its wheels 0.185 m wide. Give it in metres",
        ),
        (
            "centre_x_m = 0.035",
            "centre_x_m = 0.5",
            "the axle is not under the body. Correct body.centre_x_m or body.length_m",
        ),
        (
            "clearance_m = 0.018",
            "clearance_m = 0.0",
            "the body lies on the floor. Raise body.clearance_m, or leave out [drive]",
        ),
        (
            "min_range_m = 0.02",
            "min_range_m = 3.0",
            "devices[nose]: min_range_m 3 is not below max_range_m 2. Correct either",
        ),
    ],
)
def test_a_fault_of_a_robot_is_reported_in_one_line(tmp_path: Path, old: str, new: str, line: str) -> None:
    assert values(tmp_path, changed(ROVER, old, new)) == line


@pytest.mark.parametrize(
    "old, new, line",
    [
        (
            "radius_m = 0.10",
            "radius_m = -0.10",
            "targets[ball].radius_m: should be at least 0.001 m, got -0.1. Correct it",
        ),
        ("x_m = 1.35", "x_m = inf", "targets[ball].x_m: should be a finite number, got inf. Correct it"),
        (
            '"green"',
            '"gren"',
            "targets[ball].colour: unknown colour 'gren'. Did you mean 'green'? Or take [r, g, b]",
        ),
        ('"blue-box"', '"red-box"', "two things are named 'red-box'. Give each a name of its own"),
        ('"blue-box"', '"wall-north"', "two things are named 'wall-north'. Give each a name of its own"),
        ('"cylinder"', '"cone"', "obstacles[yellow-post].shape: 'cone' is unknown. Did you mean 'cylinder'?"),
        (
            "[0.8, 1.25]",
            "[1.25, 0.8]",
            "variation.obstacle_scale: the lower end 1.25 is above the upper end 0.8. Swap them",
        ),
        (
            "[0.8, 1.25]",
            "[1, 2, 3]",
            "variation.obstacle_scale: should be [from, to], got a list of 3. Correct it",
        ),
        (
            "[0.6, 1.4]",
            "[-0.6, 1.4]",
            "variation.light_elevation_rad[#1]: should be greater than 0 rad, got -0.6. Correct it",
        ),
        (
            "[variation]",
            "[randomisation]\ncamera_noise = [8.0, 0.0]\n[variation]",
            "randomisation.camera_noise: the lower end 8 is above the upper end 0. Swap them",
        ),
        (
            "[variation]",
            "[randomisation]\nwheel_gain = [0.0, 1.0]\n[variation]",
            "randomisation.wheel_gain[#1]: should be at least 0.5, got 0.0. Correct it",
        ),
        (
            "[variation]",
            "[randomisation]\ncamera_noice = [0.0, 1.0]\n[variation]",
            "randomisation.camera_noice: is unknown. Correct it or take it out. Did you mean 'camera_noise'?",
        ),
        (
            "[variation]",
            '[randomisation]\npatterns = ["chequer"]\n[variation]',
            (
                "randomisation.patterns[#1]: "
                "should be 'plain', 'checker', 'planks', 'speckle' or 'grass', got 'chequer'. Correct it"
            ),
        ),
        (
            "[variation]",
            "[conditions]\ncamera_noise = -1.0\n[variation]",
            "conditions.camera_noise: should be at least 0, got -1.0. Correct it",
        ),
        (
            'name = "arena"',
            'name = "arena"\n"a\\nb" = 1',
            (
                "'a\\nb': is unknown. Correct it or take it out. There are: conditions, floor, "
                "light, name, obstacles, randomisation, start, summary, targets, variation, walls."
            ),
        ),
        (
            "x_m = 1.35\ny_m = 1.2",
            "x_m = 0.8\ny_m = 0.9",
            "targets[ball]: it is in the obstacle 'red-box'. Move either so that they are apart",
        ),
        (
            "x_m = 1.35",
            "x_m = 1.95",
            "targets[ball]: it is in or beyond a wall. The walls are at x = ±2 m and y = ±2 m: move it in between",
        ),
        (
            "x_m = -1.4",
            "x_m = -0.5",
            "start: it is in the obstacle 'orange-post'. Move either so that they are apart",
        ),
    ],
)
def test_a_fault_of_a_world_is_reported_in_one_line(tmp_path: Path, old: str, new: str, line: str) -> None:
    assert values(tmp_path, changed(ARENA, old, new)) == line


@pytest.mark.parametrize(
    "key, value, form, got",
    [
        ("camera_noise", "3.0", "[from, to], or false", "3.0"),
        ("camera_noise", "[3.0]", "[from, to], or false", "a list of 1"),
        ("camera_noise", "[]", "[from, to], or false", "a list of 0"),
        ("camera_noise", "[1, 2, 3]", "[from, to], or false", "a list of 3"),
        ("camera_noise", "true", "[from, to], or false", "true"),
        ("camera_noise", '"off"', "[from, to], or false", "'off'"),
        ("hue_gap_deg", "[10, 60]", "a number, or false", "a list of 2"),
        ("patterns", "[]", "a list of one pattern or more, or false", "a list of 0"),
        ("patterns", '"plain"', "a list of one pattern or more, or false", "'plain'"),
    ],
)
def test_what_is_no_range_is_reported_with_how_one_is_written(
    tmp_path: Path, key: str, value: str, form: str, got: str
) -> None:
    line = values(tmp_path, f"{ARENA}[randomisation]\n{key} = {value}\n")
    assert line == f"randomisation.{key}: should be {form}, got {got}. Correct it"


@pytest.mark.parametrize(
    "old, new, line",
    [
        ("target_hidden = true", 'target_hidden = "no"', "target_hidden: should be true or false, got 'no'"),
        ("[[targets]]", "[targets]", "targets: should be a list of tables: [[targets]], got a table"),
        ("[floor]", "[[floor]]", "floor: should be a table, got a list of 1"),
    ],
)
def test_a_value_of_another_type_is_reported_with_the_type_that_is_expected(
    tmp_path: Path, old: str, new: str, line: str
) -> None:
    assert values(tmp_path, changed(ARENA, old, new)).removeprefix("variation.") == f"{line}. Correct it"


def test_a_thing_in_a_list_without_a_name_is_counted_from_one(tmp_path: Path) -> None:
    assert values(tmp_path, changed(ROVER, 'name = "left_encoder"\n', "")).startswith("devices[#3].name: is missing")


def test_an_unknown_key_at_the_top_may_have_the_name_of_a_device_kind(tmp_path: Path) -> None:
    line = values(tmp_path, "encoder = 1\n" + ROVER)
    assert line.startswith("encoder: is unknown. Correct it or take it out. There are: body, ")
    assert {"devices", "drive"} <= set(line.partition("There are: ")[2].rstrip(".").split(", "))


def test_an_unknown_key_may_have_the_name_of_the_kind_that_it_stands_in(tmp_path: Path) -> None:
    line = values(tmp_path, changed(ROVER, 'kind = "camera"', 'kind = "camera"\ncamera = 1'))
    assert line.startswith("devices[eye].camera: is unknown")


@pytest.mark.parametrize(
    "old, new, keys",
    [
        ("width_m = 0.185", "width = 0.185", ["body.width"]),
        ("width_m = 0.185", "breite = 0.185", ["body.width_m", "body.breite"]),
        ("[60, 65, 75]", "[256, -1, 75]", ["body.colour[#1]", "body.colour[#2]"]),
        ("[60, 65, 75]", "[]", ["body.colour"]),
    ],
    ids=["misspelt", "missing", "items", "short"],
)
def test_every_fault_is_reported_once_and_none_that_follows_from_another(
    tmp_path: Path, old: str, new: str, keys: list[str]
) -> None:
    assert [error.key for error in errors(tmp_path, changed(ROVER, old, new))] == keys


def test_all_things_that_stand_in_each_other_are_reported(tmp_path: Path) -> None:
    world = changed(changed(ARENA, "x_m = 1.35", "x_m = 1.95"), "x_m = -1.4", "x_m = -0.5")
    assert [error.key for error in errors(tmp_path, world)] == ["targets[ball]", "start"]
