from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from robotcore.description import (
    Randomisation,
    RobotDescription,
    WorldDescription,
    load_any,
    load_robot,
    load_world,
    robot_names,
    world_names,
)
from robotcore.errors import DescriptionError, UnknownNameError, UsageError
from tests.robotcore.description.files import ARENA, ROVER, find_errors
from tests.texts import Raises


@pytest.mark.parametrize("name", [*robot_names(), *world_names()])
def test_a_shipped_description_loads_by_its_name(name: str) -> None:
    load = load_robot if name in robot_names() else load_world
    assert load(name) == load_any(name)
    assert load(name).name == name


def test_kind_of_a_file_is_found_by_its_content(tmp_path: Path) -> None:
    robot, world = tmp_path / "one.toml", tmp_path / "two.toml"
    robot.write_text(ROVER, encoding="utf-8")
    world.write_text(ARENA, encoding="utf-8")
    assert isinstance(load_any(str(robot)), RobotDescription)
    assert isinstance(load_any(str(world)), WorldDescription)


def test_robot_has_its_file_and_equals_a_robot_from_another_file(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(ROVER, encoding="utf-8")
    shipped = load_robot("rover")
    assert (shipped.file, shipped.source) == (None, "robot rover")
    for mine in (load_robot(str(file)), load_any(str(file))):
        assert isinstance(mine, RobotDescription)
        assert (mine.file, mine.source) == (str(file), str(file))
        assert mine == shipped
        assert mine.model_dump_json() == shipped.model_dump_json()
        assert RobotDescription.model_validate(mine).model_copy(update={"summary": "mine"}).file == str(file)


def test_name_of_a_file_may_be_its_ending_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(".toml").write_text(ROVER, encoding="utf-8")
    assert load_robot(".toml").file == ".toml"


@pytest.mark.parametrize(
    "load, kind", [(load_robot, "unknown-robot"), (load_world, "unknown-world"), (load_any, "unknown-robot-or-world")]
)
def test_error_suggests_the_nearest_name_or_a_file_that_is_named_without_its_ending(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises, load: Callable[[str], object], kind: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_own.toml").write_text("")
    for name in ("my_own", "arna", "rovr", "my_own.tml"):
        with raises(UnknownNameError, kind):
            load(name)


def test_name_of_another_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wall.py").touch()
    with raises(UsageError, "not-a-description"):
        load_any("wall.py")


@pytest.mark.parametrize("name", ["a" * 5000, "a\0b", ""], ids=["long", "NUL", "empty"])
def test_name_that_no_file_can_have_is_unknown(name: str) -> None:
    with pytest.raises(UnknownNameError) as raised:
        load_robot(name)
    assert raised.value.kind == "unknown-robot"


def test_file_of_the_other_kind_is_refused(tmp_path: Path, raises: Raises) -> None:
    robot, world = tmp_path / "one.toml", tmp_path / "two.toml"
    robot.write_text(ROVER, encoding="utf-8")
    world.write_text(ARENA, encoding="utf-8")
    with raises(DescriptionError, "is-a-robot"):
        load_world(str(robot))
    with raises(DescriptionError, "is-a-world"):
        load_robot(str(world))


def test_a_table_of_a_list_with_single_brackets_is_explained(tmp_path: Path, raises: Raises) -> None:
    file = tmp_path / "robot.toml"
    file.write_text("[devices]\na = 1\n[devices]\na = 2\n")
    with raises(DescriptionError, "not-toml"):
        load_robot(str(file))


@pytest.mark.parametrize(
    "content, kind",
    [
        (b"", "no-robot-and-no-world"),
        (bytes(range(256)), "not-text"),
        (ARENA.encode("utf-16"), "not-text"),
        (b"a = " + b"[" * 100_000, "nested-too-deep"),
        (ARENA.encode() + b"[light." + b".".join([b"a"] * 20_000) + b"]\n", "too-many-dots"),
        (b"name = \n", "not-toml"),
        (b"a = " + b"9" * 5000, "not-toml"),
    ],
    ids=["empty", "bytes", "utf-16", "lists", "tables", "syntax", "number"],
)
def test_file_without_a_description_is_reported_in_one_line(tmp_path: Path, content: bytes, kind: str) -> None:
    (error,) = find_errors(tmp_path, content)
    assert (error.key, error.kind) == ("", kind)


def test_byte_order_mark_is_ignored(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_bytes(b"\xef\xbb\xbf" + ARENA.encode())
    assert load_world(str(file)) == load_world("arena")


def test_a_quantity_is_switched_off_by_false_and_the_others_keep_their_ranges(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(ARENA + "[randomisation]\ncamera_noise = false\nwheel_gain = [0.9, 1.0]\n", encoding="utf-8")
    ranges = load_world(str(file)).randomisation
    assert (ranges.camera_noise, ranges.wheel_gain) == (None, (0.9, 1.0))
    assert ranges.light_brightness == Randomisation().light_brightness


def test_a_backends_section_is_kept_under_its_name(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(ROVER + "[mock]\npins = [1, 2]\n", encoding="utf-8")
    assert load_robot(str(file)).backends["mock"] == {"pins": (1, 2)}


@pytest.mark.parametrize("name", ["missing.toml", ".", "none/such", "with\0null.toml"])
def test_file_that_cannot_be_read_is_reported_with_the_reason(name: str, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "unreadable-file"):
        load_any(f"{tmp_path}/{name}")


def test_device_file_is_not_read(raises: Raises) -> None:
    with raises(UsageError, "no-regular-file"):
        load_world("/dev/zero")
