from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from robotcore.plugins import kind_names
from tests.robotcore.description.files import ARENA, ROVER, find_errors, replace
from tests.texts import CheckText

ROBOT_MISTAKES = [
    ("length_m", "lenght_m", "body.lenght_m", "unknown-key"),
    ('name = "nose"\nmount = { x_m', 'name = "nose"\nmount = { x_mm', "devices[nose].mount.x_mm", "unknown-key"),
    ("[safety]", "[pybulet]\n[safety]", "pybulet", "unknown-key"),
    ("[safety]", "[backends.mock]\n[safety]", "backends", "misplaced-section"),
    ("[body]", "mock = 3\n[body]", "mock", "wrong-value"),
    ("track_m = 0.155\n", "", "drive.track_m", "missing-key"),
    ("cone_rad", "#", "devices[nose].cone_rad", "missing-key"),
    ("width_m = 0.185", 'width_m = "wide"', "body.width_m", "wrong-value"),
    ("width_m = 0.185", "width_m = nan", "body.width_m", "wrong-value"),
    ("width_m = 0.185", f"width_m = 0x{'f' * 5000}", "body.width_m", "number-too-long"),
    ("[60, 65, 75]", "[60, 65, 256]", "body.colour[#3]", "out-of-bounds"),
    ("[60, 65, 75]", "7", "body.colour", "wrong-form"),
    ("[60, 65, 75]", "[60, 65]", "body.colour", "wrong-form"),
    ("[60, 65, 75]", "[60, 65, 7.5]", "body.colour[#3]", "wrong-value"),
    ('name = "rover"', "name = 3", "name", "wrong-value"),
    ('kind = "range_sensor"', 'kind = "range-sensor"', "devices[nose].kind", "unknown-tag"),
    ('kind = "range_sensor"', 'kind = ["range_sensor"]', "devices[nose].kind", "wrong-value"),
    ('kind = "range_sensor"', "kind = 3", "devices[nose].kind", "wrong-value"),
    ('kind = "range_sensor"\n', "", "devices[nose].kind", "missing-tag"),
    ('"right_motor"\nmax', '"left_motor"\nmax', "", "same-name"),
    ('name = "rover"', 'name = "My rover"', "name", "no-name"),
    ("mount = { x_m = 0.14, z_m = 0.10 }", "mount = { z_m = -0.10 }", "devices[nose].mount.z_m", "out-of-bounds"),
    ('left = "left_motor"', 'left = "right_motor"', "drive", "same-motor"),
    ('left = "left_motor"', 'left = "port"', "", "no-such-device"),
    ('left = "left_motor"', 'left = "left_moter"', "", "no-such-device"),
    ('name = "right_motor"', 'name = "other"', "", "no-such-device"),
    ('left_encoder = "left_encoder"\n', "", "drive", "one-encoder"),
    ("track_m = 0.155", "track_m = 0.3", "", "body-narrower-than-wheels"),
    ("wheel_radius_m = 0.0325", "wheel_radius_m = 32.5", "", "wheel-radius-not-in-metres"),
    ("track_m = 0.155", "track_m = 15.5", "", "wheel-size-not-in-metres"),
    ("centre_x_m = 0.035", "centre_x_m = 0.5", "", "axle-not-under-body"),
    ("clearance_m = 0.018", "clearance_m = 0.0", "", "body-on-floor"),
    ("cone_rad = 0.5236", "cone_rad = 30", "devices[nose].cone_rad", "out-of-bounds"),
    ("z_m = 0.10 }\nmin", "z_m = 0.10, yaw_rad = -15.0 }\nmin", "devices[nose].mount.yaw_rad", "out-of-bounds"),
    ("z_m = 0.10 }\nmin", "z_m = 0.10, pitch_rad = 6.4 }\nmin", "devices[nose].mount.pitch_rad", "out-of-bounds"),
    ("lag_s = 0.05", "lag_s = 1e-300", "devices[left_motor].lag_s", "lag-too-short"),
    ("mass_kg = 1.07", "mass_kg = 1e308", "body.mass_kg", "out-of-bounds"),
    ("min_range_m = 0.02", "min_range_m = 3.0", "devices[nose]", "ranges-in-wrong-order"),
]

WORLD_MISTAKES = [
    ("radius_m = 0.10", "radius_m = -0.10", "targets[ball].radius_m", "out-of-bounds"),
    ("x_m = 1.35", "x_m = inf", "targets[ball].x_m", "wrong-value"),
    ("target_hidden = true", 'target_hidden = "no"', "variation.target_hidden", "wrong-value"),
    ("[[targets]]", "[targets]", "targets", "wrong-form"),
    ("[floor]", "[[floor]]", "floor", "wrong-value"),
    ('"green"', '"gren"', "targets[ball].colour", "unknown-colour"),
    ('"blue-box"', '"red-box"', "", "same-name"),
    ('"blue-box"', '"wall-north"', "", "same-name"),
    ('"cylinder"', '"cone"', "obstacles[yellow-post].shape", "unknown-tag"),
    ("[0.8, 1.25]", "[1.25, 0.8]", "variation.obstacle_scale", "ends-in-wrong-order"),
    ("[0.8, 1.25]", "[1, 2, 3]", "variation.obstacle_scale", "wrong-form"),
    ("[0.6, 1.4]", "[35, 1.4]", "variation.light_elevation_rad[#1]", "out-of-bounds"),
    ("[0.6, 1.4]", "[-0.6, 1.4]", "variation.light_elevation_rad[#1]", "out-of-bounds"),
    (
        "[variation]",
        "[randomisation]\ncamera_noise = [8.0, 0.0]\n[variation]",
        "randomisation.camera_noise",
        "ends-in-wrong-order",
    ),
    (
        "[variation]",
        "[randomisation]\ncamera_noice = [0.0, 1.0]\n[variation]",
        "randomisation.camera_noice",
        "unknown-key",
    ),
    (
        "[variation]",
        '[randomisation]\npatterns = ["chequer"]\n[variation]',
        "randomisation.patterns[#1]",
        "wrong-value",
    ),
    ("[variation]", "[conditions]\ncamera_noise = -1.0\n[variation]", "conditions.camera_noise", "out-of-bounds"),
    ('name = "arena"', 'name = "arena"\n"a\\nb" = 1', "'a\\nb'", "unknown-key"),
    ("x_m = 1.35\ny_m = 1.2", "x_m = 0.8\ny_m = 0.9", "targets[ball]", "in-obstacle"),
    ("x_m = 1.35", "x_m = 1.95", "targets[ball]", "beyond-wall"),
    ("x_m = -1.4", "x_m = -0.5", "start", "in-obstacle"),
    ("[walls]", "[[lines]]\nwidth_m = 0.02\n[walls]", "lines[#1].points_m", "missing-key"),
    ("[walls]", "[[lines]]\nwidth_m = 0.02\npoints_m = [[0, 0]]\n[walls]", "lines[#1].points_m", "wrong-form"),
    ("[walls]", "[[lines]]\nwidth_m = 0.02\npoints_m = [[0, 0], [1]]\n[walls]", "lines[#1].points_m[#2]", "wrong-form"),
    (
        "[walls]",
        "[[lines]]\nwidth_m = 2e-5\npoints_m = [[0, 0], [1, 0]]\n[walls]",
        "lines[#1].width_m",
        "out-of-bounds",
    ),
    (
        "[walls]",
        "[[lines]]\nwidth_m = 0.02\nclosed = true\npoints_m = [[0, 0], [1, 0], [1e-9, 0]]\n[walls]",
        "lines[#1]",
        "same-point",
    ),
    (
        "[walls]",
        f"[[lines]]\nwidth_m = 0.02\npoints_m = {[[each / 1000, 0] for each in range(600)]}\n" * 2 + "[walls]",
        "",
        "too-many-points",
    ),
]


def name_cases(cases: list[tuple[str, str, str, str]]) -> list[str]:
    return [f"{key} {kind}" for *_, key, kind in cases]


@pytest.mark.parametrize("old, new, key, kind", ROBOT_MISTAKES, ids=name_cases(ROBOT_MISTAKES))
def test_mistake_in_a_robots_file_has_its_key_and_kind(
    tmp_path: Path, check_text: CheckText, old: str, new: str, key: str, kind: str
) -> None:
    (error,) = find_errors(tmp_path, replace(ROVER, old, new))
    assert (error.key, error.kind) == (key, kind)
    check_text(error, hide=[" or ".join(map(json.dumps, kind_names()))])


@pytest.mark.parametrize("old, new, key, kind", WORLD_MISTAKES, ids=name_cases(WORLD_MISTAKES))
def test_mistake_in_a_worlds_file_has_its_key_and_kind(
    tmp_path: Path, check_text: CheckText, old: str, new: str, key: str, kind: str
) -> None:
    (error,) = find_errors(tmp_path, replace(ARENA, old, new))
    assert (error.key, error.kind) == (key, kind)
    check_text(error)


@pytest.mark.parametrize(
    "key, value",
    [
        ("camera_noise", "3.0"),
        ("camera_noise", "[3.0]"),
        ("camera_noise", "true"),
        ("hue_gap_deg", "[10, 60]"),
        ("patterns", "[]"),
        ("patterns", '"plain"'),
    ],
)
def test_value_of_the_wrong_form_is_reported_with_the_right_form(
    tmp_path: Path, check_text: CheckText, key: str, value: str
) -> None:
    (error,) = find_errors(tmp_path, f"{ARENA}[randomisation]\n{key} = {value}\n")
    assert (error.key, error.kind) == (f"randomisation.{key}", "wrong-form")
    check_text(error)


def test_item_of_a_list_without_a_name_is_counted_from_one(tmp_path: Path) -> None:
    (error,) = find_errors(tmp_path, replace(ROVER, 'name = "left_encoder"\n', ""))
    assert (error.key, error.kind) == ("devices[#3].name", "missing-key")


def test_unknown_key_at_the_top_may_have_the_name_of_a_device_kind(tmp_path: Path) -> None:
    (error,) = find_errors(tmp_path, "encoder = 1\n" + ROVER)
    assert (error.key, error.kind) == ("encoder", "unknown-key")
    assert {"body", "devices", "drive"} <= set(re.findall(r"\w+", error.remedy))


def test_unknown_key_may_have_the_name_of_its_items_kind(tmp_path: Path) -> None:
    (error,) = find_errors(tmp_path, replace(ROVER, 'kind = "camera"', 'kind = "camera"\ncamera = 1'))
    assert (error.key, error.kind) == ("devices[eye].camera", "unknown-key")


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
def test_each_mistake_is_reported_once_without_its_consequences(
    tmp_path: Path, old: str, new: str, keys: list[str]
) -> None:
    assert [error.key for error in find_errors(tmp_path, replace(ROVER, old, new))] == keys
