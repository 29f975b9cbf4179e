from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from robotcore.cli.scaffold import DRIVER, PROJECT, Template, make, require_free
from robotcore.errors import UsageError
from tests.robotcore.cli.scaffold.conftest import HOME


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


def texts_of(folder: Path) -> dict[str, str]:
    """Return what is in a project: by its path, each file's text."""
    files = (file for file in folder.rglob("*") if file.is_file())
    return {str(file.relative_to(folder)): file.read_text(encoding="utf-8") for file in files}


@pytest.mark.parametrize("template", [PROJECT, DRIVER], ids=lambda each: each.folder)
def test_nothing_is_left_of_the_templates_own_name(template: Template, tmp_path: Path) -> None:
    made = tmp_path / "hauls-2"
    make(template, made)
    answer = str(texts_of(made)).lower()
    assert not [each for each in ("my-robot", "my_robot", "my-board", "my_board", "myboard") if each in answer]
    assert "hauls_2.toml" in texts_of(made)


def test_a_name_that_holds_the_templates_own_is_put_once(tmp_path: Path) -> None:
    make(PROJECT, tmp_path / "not-my-robot")
    assert 'name = "not-my-robot"' in (tmp_path / "not-my-robot" / "pyproject.toml").read_text()
    assert 'name = "not_my_robot"' in (tmp_path / "not-my-robot" / "not_my_robot.toml").read_text()


@pytest.mark.parametrize("cache", ["__pycache__", ".ruff_cache", ".pytest_cache"])
def test_what_installers_and_linters_leave_is_left_out(
    cache: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed = tmp_path / "installed"
    (installed / "tests" / cache).mkdir(parents=True)
    (installed / "tests" / cache / "test_search.pyc").write_bytes(b"\xcb\r\r\n")
    (installed / "tests" / "test_search.py").write_text("")
    monkeypatch.setitem(PROJECT.__dict__, "root", installed)
    make(PROJECT, tmp_path / "scout")
    assert texts_of(tmp_path / "scout") == {"tests/test_search.py": ""}


def test_files_have_the_users_usual_permissions(tmp_path: Path) -> None:
    usual = tmp_path / "usual"
    usual.mkdir()
    make(PROJECT, tmp_path / "scout")
    assert (tmp_path / "scout").stat().st_mode == usual.stat().st_mode


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_nothing_is_left_where_a_signal_ends_it(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = Template.named

    def interrupted(template: Template, text: str, name: str) -> str:
        if text == "room.toml":
            assert any(tmp_path.rglob("*.toml")) or any(tmp_path.rglob("*.py"))
            signal.raise_signal(number)
        return named(template, text, name)

    monkeypatch.setattr(Template, "named", interrupted)
    assert execute(["new", str(tmp_path / "scout")]) == 128 + number
    assert not any(tmp_path.iterdir())


@pytest.mark.skipif(os.name != "posix", reason="a shell limits what may be written")
def test_nothing_is_left_where_the_files_cannot_be_written(tmp_path: Path) -> None:
    new = [sys.executable, "-m", "robotcore", "new", "scout"]
    limited = ["sh", "-c", 'ulimit -f 3 && exec "$@"', "sh", *new]
    environment = {**os.environ, "PYTHONPATH": str(HOME), "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run(limited, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert ended.stderr.startswith("error: scout cannot be made: File too large. Nothing is left of it")
    assert not any(tmp_path.iterdir())


def test_a_name_that_the_disk_does_not_take_is_refused_in_words(tmp_path: Path) -> None:
    folder = tmp_path / ("x" * 300)
    with pytest.raises(UsageError, match="cannot be made: File name too long"):
        make(PROJECT, folder)
    assert not any(tmp_path.iterdir())
