from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from robotcore.cli.scaffold import DRIVER, KIND, PROJECT, Template, make, require_free
from robotcore.cli.scaffold import template as module
from robotcore.description import load_robot
from robotcore.errors import UsageError
from tests.robotcore.cli.scaffold.test_first_commands import HOME
from tests.texts import CheckText, Raises


@pytest.mark.parametrize("name", ["my-robot", "my_robot", "r2", "a-1-b"])
def test_accepts_a_free_name(name: str, tmp_path: Path) -> None:
    require_free(PROJECT, tmp_path / name)
    require_free(DRIVER, tmp_path / name)


@pytest.mark.parametrize(
    "name, meant",
    [
        ("My Robot", "my-robot"),
        ("-robot", "robot"),
        ("my--robot", "my-robot"),
        ("robot.py", "robot-py"),
        ("'; rm -rf ~", "rm-rf"),
    ],
)
def test_suggests_a_valid_name(name: str, meant: str, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "invalid-project-name", name=name, meant=meant):
        require_free(PROJECT, tmp_path / name)


@pytest.mark.parametrize("name", ["2wd", "süß", "_", "robot\n"])
def test_refuses_a_name_that_is_invalid_for_a_module(name: str, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "invalid-project-name", name=name):
        require_free(PROJECT, tmp_path / name)


@pytest.mark.parametrize("template", [PROJECT, DRIVER, KIND], ids=lambda each: each.folder)
def test_refuses_a_name_that_is_too_long_for_a_robot(template: Template, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "invalid-project-name", name="a" * 65, meant=""):
        require_free(template, tmp_path / ("a" * 65))


def test_the_robot_of_a_project_with_the_longest_name_is_valid(tmp_path: Path) -> None:
    make(PROJECT, tmp_path / ("a" * 64))
    assert load_robot(str(tmp_path / ("a" * 64) / f"{'a' * 64}.toml")).name == "a" * 64


@pytest.mark.parametrize("folder", ["", ".", "..", "/"])
def test_refuses_a_path_without_a_name(folder: str, check_text: CheckText) -> None:
    with pytest.raises(UsageError) as raised:
        require_free(PROJECT, Path(folder))
    assert raised.value.kind == "invalid-project-name"
    check_text(str(raised.value))


@pytest.mark.parametrize("name", ["pytest", "ruff", "tox", "uv", "conftest", "setup"])
def test_refuses_the_name_of_a_tools_configuration_also_if_the_tool_is_not_installed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    with raises(UsageError, "project-name-in-use", name=name, use="the name of a tool's configuration file"):
        require_free(KIND, tmp_path / name)


@pytest.mark.parametrize("name", ["class", "test", "numpy", "con", "com1", "robotcore", "drivers", "room", "search"])
def test_refuses_a_name_in_use(name: str, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "project-name-in-use", name=name):
        require_free(PROJECT, tmp_path / name)


@pytest.mark.parametrize("name", ["kinematic", "mock", "drive"])
def test_refuses_a_driver_with_the_name_of_a_backend_or_of_a_key(name: str, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "project-name-in-use", name=name):
        require_free(DRIVER, tmp_path / name)
    require_free(PROJECT, tmp_path / name)


@pytest.mark.parametrize("name", ["kind", "none", "speed"])
def test_refuses_a_kind_whose_class_hides_another_one(name: str, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "project-name-in-use", name=name):
        require_free(KIND, tmp_path / name)
    require_free(PROJECT, tmp_path / name)


@pytest.mark.parametrize("kind", ["folder", "file", "dangling link"])
def test_refuses_a_folder_that_exists(kind: str, tmp_path: Path, raises: Raises) -> None:
    there = tmp_path / "my-robot"
    match kind:
        case "folder":
            there.mkdir()
        case "file":
            there.touch()
        case _:
            there.symlink_to("nowhere")
    with raises(UsageError, "folder-exists"):
        require_free(PROJECT, there)


def test_refuses_a_folder_without_a_parent(tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "no-such-folder"):
        require_free(PROJECT, tmp_path / "nowhere" / "my-robot")


def read_texts(folder: Path) -> dict[str, str]:
    """Return the text of each file of a project by its path."""
    files = (file for file in folder.rglob("*") if file.is_file())
    return {str(file.relative_to(folder)): file.read_text(encoding="utf-8") for file in files}


@pytest.mark.parametrize("template", [PROJECT, DRIVER, KIND], ids=lambda each: each.folder)
def test_the_copy_does_not_have_the_templates_own_name(template: Template, tmp_path: Path) -> None:
    made = tmp_path / "hauls-2"
    make(template, made)
    answer = str(read_texts(made)).lower()
    own = (f"my{between}{noun}" for noun in ("robot", "board", "sensor") for between in ("-", "_", ""))
    assert not [each for each in own if each in answer]
    assert {"hauls_2.toml", "hauls_2.py"} & read_texts(made).keys()


def test_kind_of_another_package_is_no_name_of_a_new_one(tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "project-name-in-use", name="range-sensor"):
        require_free(KIND, tmp_path / "range-sensor")


def test_driver_and_kind_at_once_are_refused(tmp_path: Path) -> None:
    assert execute(["new", "--driver", "--kind", str(tmp_path / "both")]) == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("cache", ["__pycache__", ".ruff_cache"])
def test_caches_are_not_copied(cache: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    installed = tmp_path / "installed"
    (installed / "tests" / cache).mkdir(parents=True)
    (installed / "tests" / cache / "test_search.pyc").write_bytes(b"\xcb\r\r\n")
    (installed / "tests" / "test_search.py").write_text("")
    monkeypatch.setitem(PROJECT.__dict__, "root", installed)
    make(PROJECT, tmp_path / "scout")
    assert read_texts(tmp_path / "scout") == {"tests/test_search.py": ""}


def test_a_project_has_the_permissions_of_a_new_folder(tmp_path: Path) -> None:
    usual = tmp_path / "usual"
    usual.mkdir()
    make(PROJECT, tmp_path / "scout")
    assert (tmp_path / "scout").stat().st_mode == usual.stat().st_mode


def test_nothing_is_left_after_a_signal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rename_text = Template.rename_text

    def interrupted(template: Template, text: str, name: str) -> str:
        if text == "room.toml":
            assert any(tmp_path.rglob("*.toml")) or any(tmp_path.rglob("*.py"))
            signal.raise_signal(signal.SIGTERM)
        return rename_text(template, text, name)

    monkeypatch.setattr(Template, "rename_text", interrupted)
    assert execute(["new", str(tmp_path / "scout")]) == 128 + signal.SIGTERM
    assert not any(tmp_path.iterdir())


@pytest.mark.skipif(os.name != "posix", reason="a shell limits what may be written")
def test_nothing_is_left_if_the_files_cannot_be_written(tmp_path: Path, check_text: CheckText) -> None:
    new = [sys.executable, "-m", "robotcore", "new", "scout"]
    limited = ["sh", "-c", 'ulimit -f 3 && exec "$@"', "sh", *new]
    environment = {**os.environ, "PYTHONPATH": str(HOME), "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run(limited, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    check_text(ended.stderr)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    "number", [errno.ENOSPC, errno.EACCES, errno.ENAMETOOLONG, errno.EIO], ids=errno.errorcode.__getitem__
)
def test_the_remedy_fits_the_error_of_the_system(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    def fail(*_: object) -> None:
        raise OSError(number, "it fails")

    monkeypatch.setattr(module, "_copy", fail)
    with pytest.raises(UsageError) as raised:
        make(PROJECT, tmp_path / "scout")
    check_text(str(raised.value))


@pytest.mark.posix("Windows keeps a working folder")
@pytest.mark.parametrize("folder", ["scout", "sub/scout"])
def test_the_remedy_in_a_deleted_working_folder_is_another_folder(
    folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    enter_deleted_folder(tmp_path, monkeypatch)
    with pytest.raises(UsageError) as raised:
        make(PROJECT, Path(folder))
    assert raised.value.kind == "folder-unwritable"
    check_text(str(raised.value))


def enter_deleted_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "deleted").mkdir()
    monkeypatch.chdir(tmp_path / "deleted")
    (tmp_path / "deleted").rmdir()
