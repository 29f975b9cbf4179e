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
from tests.robotcore.description.files import ARENA, ROVER, values


@pytest.mark.parametrize("name", robot_names())
def test_a_shipped_robot_loads_by_its_name(name: str) -> None:
    assert load_robot(name) == load_any(name)
    assert load_robot(name).name == name


@pytest.mark.parametrize("name", world_names())
def test_a_shipped_world_loads_by_its_name(name: str) -> None:
    assert load_world(name) == load_any(name)
    assert load_world(name).name == name


def test_a_file_is_reported_by_its_content(tmp_path: Path) -> None:
    robot, world = tmp_path / "one.toml", tmp_path / "two.toml"
    robot.write_text(ROVER, encoding="utf-8")
    world.write_text(ARENA, encoding="utf-8")
    assert isinstance(load_any(str(robot)), RobotDescription)
    assert isinstance(load_any(str(world)), WorldDescription)


def test_a_robot_is_reported_by_the_file_that_it_is_from_which_makes_no_other_robot_of_it(tmp_path: Path) -> None:
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


def test_a_file_may_be_called_by_its_ending_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(".toml").write_text(ROVER, encoding="utf-8")
    assert load_robot(".toml").file == ".toml"


@pytest.mark.parametrize("load, kind", [(load_robot, "robot"), (load_world, "world"), (load_any, "robot or world")])
def test_a_file_that_is_named_without_its_ending_is_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, load: Callable[[str], object], kind: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_own.toml").write_text("")
    with pytest.raises(UnknownNameError) as raised:
        load("my_own")
    assert str(raised.value) == f"unknown {kind} 'my_own'. Did you mean the file my_own.toml?"


@pytest.mark.parametrize("name", ["a" * 5000, "a\0b", ""])
def test_a_name_that_can_be_no_file_is_unknown_all_the_same(name: str) -> None:
    with pytest.raises(UnknownNameError, match="unknown robot"):
        load_robot(name)


def test_a_robot_given_as_a_world_is_reported_so_and_the_other_way_round(tmp_path: Path) -> None:
    robot, world = tmp_path / "one.toml", tmp_path / "two.toml"
    robot.write_text(ROVER, encoding="utf-8")
    world.write_text(ARENA, encoding="utf-8")
    with pytest.raises(DescriptionError, match="it describes a robot, not a world"):
        load_world(str(robot))
    with pytest.raises(DescriptionError, match="it describes a world, not a robot"):
        load_robot(str(world))


@pytest.mark.parametrize(
    "content, said",
    [
        (b"", "it describes neither a robot nor a world"),
        (bytes(range(256)), "it is not text"),
        (ARENA.encode("utf-16"), "it is not text"),
        (b"a = " + b"[" * 100_000, "it is nested too deep"),
        (ARENA.encode() + b"[light." + b".".join([b"a"] * 20_000) + b"]\n", "it is nested too deep"),
        (b"name = \n", "it is not TOML: Invalid value (at line 1, column 8)"),
        (b"a = " + b"9" * 5000, "it is not TOML: Exceeds the limit"),
    ],
    ids=["empty", "bytes", "utf-16", "lists", "tables", "syntax", "number"],
)
def test_what_is_no_description_is_reported_in_one_line(tmp_path: Path, content: bytes, said: str) -> None:
    assert values(tmp_path, content).startswith(said)


def test_a_byte_order_mark_does_no_harm(tmp_path: Path) -> None:
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


def test_an_unknown_name_offers_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown robot 'rovr'. Did you mean 'rover'"):
        load_robot("rovr")
    with pytest.raises(UnknownNameError, match=r"unknown world 'arna'. Did you mean 'arena'"):
        load_world("arna")
    with pytest.raises(UnknownNameError, match=r"unknown robot or world 'opn'. Did you mean 'open'"):
        load_any("opn")


@pytest.mark.parametrize("name", ["missing.toml", ".", "none/such", "with\0null.toml"])
def test_what_cannot_be_read_is_reported_with_its_reason(name: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"Name a file that can be read") as caught:
        load_any(f"{tmp_path}/{name}")
    assert "\n" not in str(caught.value)
    assert "None" not in str(caught.value)


def test_a_device_that_never_ends_is_not_read() -> None:
    with pytest.raises(UsageError, match="/dev/zero: it is a device or a pipe"):
        load_world("/dev/zero")
