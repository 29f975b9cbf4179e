"""Imports of apps from files, with the modules beside them."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotcore.errors import BehaviourError, UsageError
from robotcore.runtime import apps, versions
from robotcore.runtime.apps import load_app, load_app_file, use_script_folder
from robotcore.runtime.forks import EXIT_STATUS
from robotcore.runtime.settings import configure
from robotcore.runtime.time_limits import build_step_limit
from tests.texts import CheckText, Raises


@pytest.fixture(autouse=True)
def _as_before(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Restore the import path and the modules after a test."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(apps, "_folder", None)
    modules = set(sys.modules)
    yield
    for name in set(sys.modules) - modules:
        del sys.modules[name]


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """Two apps in two folders, with modules of the same names beside them."""
    for name in ("a", "b"):
        (tmp_path / name / "parts").mkdir(parents=True)
        (tmp_path / name / "bare").mkdir()
        for file in ("cog", "parts/__init__", "parts/wheel", "bare/wheel"):
            (tmp_path / name / f"{file}.py").write_text(f"FROM = {name!r}")
    return tmp_path / "a" / "robot.py", tmp_path / "b" / "robot.py"


@pytest.mark.parametrize("name", ["cog", "parts", "parts.wheel", "bare.wheel"])
def test_each_app_imports_the_modules_of_its_folder(folders: tuple[Path, Path], name: str) -> None:
    for app, letter in zip(folders * 2, "abab", strict=True):
        use_script_folder(app)
        assert letter == import_module(name).FROM


def test_module_of_another_folder_is_not_found(folders: tuple[Path, Path]) -> None:
    one, other = folders
    one.with_name("extra.py").touch()
    use_script_folder(one)
    import_module("extra")
    use_script_folder(other)
    with pytest.raises(ModuleNotFoundError):
        import_module("extra")


def test_folder_is_in_the_path_once_and_an_earlier_entry_stays(
    folders: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = folders
    monkeypatch.syspath_prepend(one.parent)
    before = list(sys.path)
    for app in (one, one, other, one, other):
        use_script_folder(app)
    assert sys.path == [str(other.parent), *before]


def test_library_below_the_folder_and_earlier_modules_stay(
    folders: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = folders
    libraries = one.parent / "venv" / "site-packages"
    libraries.mkdir(parents=True)
    (libraries / "library.py").touch()
    monkeypatch.syspath_prepend(libraries)
    monkeypatch.syspath_prepend(one.parent)
    early = import_module("cog")
    use_script_folder(one)
    library = import_module("library")
    use_script_folder(other)
    assert sys.modules["library"] is library
    assert sys.modules["cog"] is early


def test_line_of_a_step_that_hangs_is_named_for_a_file_in_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    head = "import sys\nfrom robotcore import Behaviour\nclass Hanging(Behaviour):\n"
    Path("hanging.py").write_text(f"{head}    def step(self, robot):\n        return sys._getframe()\n")
    app: Any = load_app_file("hanging.py")()
    assert ", at hanging.py:5." in str(build_step_limit(app, 3.0).error(3.0, app.step(None)))


def test_version_of_a_library_without_a_known_distribution_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(versions, "_find_distributions", dict)
    assert versions.libraries(()) == {"python": platform.python_version(), "numpy": np.__version__}


def test_file_without_its_end_is_suggested(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.chdir(tmp_path)
    Path("printy.py").touch()
    with raises(UsageError, "not-an-app"):
        load_app("printy")


def test_file_whose_name_is_no_text_is_refused(tmp_path: Path, raises: Raises) -> None:
    app = tmp_path / os.fsdecode(b"\xff.py")
    app.touch()
    with raises(UsageError, "name-not-utf-8"):
        load_app_file(str(app))


def test_file_that_runs_itself_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.chdir(tmp_path)
    Path("loop.py").write_text("import robotcore\nrobotcore.run(robotcore.RunRequest('loop.py'))\n")
    with raises(BehaviourError, "app-not-importable"):
        load_app("loop.py")


@pytest.mark.parametrize("ending, kind", [("", "unknown-app"), (".py", "no-such-file")])
def test_name_that_is_too_long_is_refused(ending: str, kind: str) -> None:
    with pytest.raises(UsageError) as caught:
        load_app(5000 * "a" + ending)
    assert caught.value.kind == kind


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of a fork of a process that has threads
@pytest.mark.parametrize("place", ["the import", "the creation"])
def test_a_copy_of_the_process_that_an_app_makes_ends_before_the_run(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], place: str, check_text: CheckText
) -> None:
    app = tmp_path / "app.py"
    app.write_text(
        "import os\nfrom robotcore import Behaviour\n\ncopies = []\n\n"
        "def fork():\n    copies.append(os.fork())\n\n"
        "class App(Behaviour):\n    def __init__(self):\n        {creation}\n\n"
        "    def step(self, robot):\n        pass\n\n{import}\n".format(
            **{"creation": "pass", "import": "", place.removeprefix("the "): "fork()"}
        )
    )
    process = os.getpid()
    try:
        created = configure(load_app(str(app)), {})
    finally:
        if os.getpid() != process:  # a copy that did not end
            os._exit(0)
    (copy,) = sys.modules[type(created).__module__].copies
    assert os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1]) == EXIT_STATUS
    check_text(capfd.readouterr().err, hide=[copy])
