from __future__ import annotations

import re
from pathlib import Path

import pytest

from robotcore.cli.scaffold import DRIVER, PROJECT, Template, require_free
from robotcore.errors import UsageError


def refusal(template: Template, folder: Path) -> str:
    with pytest.raises(UsageError) as refused:
        require_free(template, folder)
    return str(refused.value)


@pytest.mark.parametrize("name", ["my-robot", "my_robot", "r2", "a-1-b", "x" * 60])
def test_takes_a_name_that_is_free(name: str, tmp_path: Path) -> None:
    require_free(PROJECT, tmp_path / name)
    require_free(DRIVER, tmp_path / name)


@pytest.mark.parametrize(
    "name, meant",
    [
        ("My Robot", "my-robot"),
        ("MyRobot", "myrobot"),
        ("-robot", "robot"),
        ("my--robot", "my-robot"),
        ("robot.py", "robot-py"),
        ("'; rm -rf ~", "rm-rf"),
    ],
)
def test_offers_the_name_that_was_meant(name: str, meant: str, tmp_path: Path) -> None:
    said = refusal(PROJECT, tmp_path / name)
    assert re.fullmatch(f"{re.escape(repr(name))} is no name for a project: .*; {meant} for instance", said)


@pytest.mark.parametrize("name", ["2wd", "süß", "机器人", "_", "robot\n", "🤖"])
def test_refuses_what_no_module_can_be_called(name: str, tmp_path: Path) -> None:
    assert "is no name for a project: take lower-case letters" in refusal(PROJECT, tmp_path / name)


@pytest.mark.parametrize(
    "name, use",
    [
        ("class", "a word of Python's own"),
        ("test", "the name of a Python module in use"),
        ("numpy", "the name of a Python module in use"),
        ("robotcore", "the name of a Python module in use"),
        ("drivers", "the name of a Python module in use"),
        ("room", "the name of something in every new project"),
        ("search", "the name of something in every new project"),
    ],
)
def test_refuses_a_name_that_stands_for_something(name: str, use: str, tmp_path: Path) -> None:
    said = refusal(PROJECT, tmp_path / name)
    assert said.startswith(f"{name!r} is {use}")
    assert said.endswith(f"Take another name, {name}-project for instance")


@pytest.mark.parametrize(
    "name, use",
    [
        ("kinematic", "the name of a backend that is installed"),
        ("mock", "the name of a backend that is installed"),
        ("drive", "a part of every robot's file"),
    ],
)
def test_refuses_a_driver_that_would_be_taken_for_another_or_for_a_part_of_a_robot(
    name: str, use: str, tmp_path: Path
) -> None:
    assert refusal(DRIVER, tmp_path / name).startswith(f"{name!r} is {use}")
    require_free(PROJECT, tmp_path / name)


@pytest.mark.parametrize("kind", ["folder", "file", "dangling link"])
def test_refuses_to_touch_what_is_there(kind: str, tmp_path: Path) -> None:
    there = tmp_path / "my-robot"
    match kind:
        case "folder":
            there.mkdir()
        case "file":
            there.touch()
        case _:
            there.symlink_to("nowhere")
    assert (
        refusal(PROJECT, there) == f"{there} is there already, and stays as it is. Take another name, or move it away"
    )


def test_refuses_a_folder_in_which_nothing_can_be_made(tmp_path: Path) -> None:
    assert "nowhere is no folder" in refusal(PROJECT, tmp_path / "nowhere" / "my-robot")
