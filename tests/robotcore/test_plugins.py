from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from pathlib import Path

import pytest

from robotcore import plugins as registry
from robotcore.compatibility import read_version
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.plugins import app_names, backend_names
from robotcore.runtime.apps import app_name, load_app
from tests.doubles.packages import forget_packages
from tests.texts import Raises

Register = Callable[..., None]
GROUPS = (registry.BACKENDS, registry.APPS, registry.FAULTS, registry.DEVICES, registry.KINDS)


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Iterator[Register]:
    """Return a function that replaces the installed entry points of all groups."""

    def install(**values: str | list[str]) -> None:
        forget_packages()
        listed = {name: [value] if isinstance(value, str) else value for name, value in values.items()}
        points = EntryPoints(
            EntryPoint(name.replace("_", "-"), value, group)
            for group in GROUPS
            for name, each in listed.items()
            for value in each
        )
        monkeypatch.setattr(registry, "entry_points", lambda: points)

    yield install
    monkeypatch.undo()
    forget_packages()


def test_everything_that_is_registered_can_be_loaded() -> None:
    assert [load_backend(name).name for name in backend_names()] == backend_names()
    assert all(load_app(name).step for name in app_names())


def test_names_are_those_of_the_entry_points(register: Register) -> None:
    register(zebra="a:B", ape="c:D")
    assert backend_names() == app_names() == ["ape", "zebra"]


def test_a_name_with_an_underscore_is_the_one_with_a_hyphen(register: Register) -> None:
    register(null_app="tests.robotcore.fakes:FunctionApp")
    assert load_app("null_app") is load_app("null-app")
    assert app_name("null_app") == "null-app"
    assert app_name("my_apps/null_app.py") == "my_apps/null_app.py"


def test_unknown_name_suggests_the_nearest_name(register: Register, raises: Raises) -> None:
    register(kinematic="a:B")
    with raises(UnknownNameError, "unknown-backend"):
        load_backend("kinematik")


def test_name_that_two_packages_register_is_refused(register: Register, raises: Raises) -> None:
    register(null_app=["mine:App", "theirs:App"])
    with raises(UsageError, "registered-twice", name="null-app"):
        load_app("null-app")


def test_package_that_is_installed_twice_registers_its_names_once(register: Register) -> None:
    register(null_app=["tests.robotcore.fakes:FunctionApp"] * 2)
    assert load_app("null-app").__name__ == "FunctionApp"


@pytest.mark.parametrize("name", ["my_apps", "my_apps/notes.txt"])
def test_folder_or_other_file_is_no_app(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_apps").mkdir()
    (tmp_path / "my_apps" / "notes.txt").touch()
    with pytest.raises(UsageError) as raised:
        load_app(name)
    assert not isinstance(raised.value, UnknownNameError)


def test_an_app_is_not_hidden_by_a_folder_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, register: Register
) -> None:
    register(null_app="tests.robotcore.fakes:FunctionApp")
    monkeypatch.chdir(tmp_path)
    for name in ("null-app", "null_app"):
        (tmp_path / name).mkdir()
        assert load_app(name).__name__ == "FunctionApp"


def test_project_that_is_not_installed_is_reported(register: Register, raises: Raises) -> None:
    register()
    with raises(UsageError, "nothing-registered"):
        load_app("green-search")


@pytest.mark.parametrize("value", ["no_such_module:Thing", "tests.robotcore.fakes:NoSuchThing"])
def test_entry_point_that_cannot_be_loaded_is_reported_with_the_cause(
    register: Register, raises: Raises, value: str
) -> None:
    register(broken=value)
    with raises(BackendMissingError, group="robotcore.backends", name="broken") as raised:
        load_backend("broken")
    assert raised.value.__cause__


def test_entry_point_that_exits_is_reported(
    register: Register, raises: Raises, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "leaving.py").write_text("import sys; sys.exit(0)\n")
    monkeypatch.syspath_prepend(tmp_path)
    register(broken="leaving:Backend")
    with raises(BackendMissingError, group="robotcore.backends", name="broken"):
        load_backend("broken")


def test_an_app_in_a_file_is_loaded_from_it(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("from robotcore import Behaviour, Status\nclass Mine(Behaviour):\n    def step(self, robot): ...\n")
    assert load_app(str(file)).__name__ == "Mine"


def test_groups_are_those_of_the_installed_project() -> None:
    assert {point.name for point in entry_points(group=registry.BACKENDS)} >= {"kinematic", "mock", "pybullet"}
    assert {point.name for point in entry_points(group=registry.APPS)} >= {"green-search", "mark-green"}
    assert {point.name for point in entry_points(group=registry.FAULTS)} >= {"drop", "noise.camera", "stall"}


def install_package(folder: Path, requirement: str) -> None:
    """Install a package with a backend, as pip does: a module and its metadata."""
    (folder / "made_elsewhere.py").write_text("class Board:\n    name = 'made-elsewhere'\n")
    metadata = folder / "made_elsewhere-0.2.dist-info"
    metadata.mkdir()
    text = f"Metadata-Version: 2.1\nName: made-elsewhere\nVersion: 0.2\nRequires-Dist: {requirement}\n"
    (metadata / "METADATA").write_text(text)
    (metadata / "entry_points.txt").write_text("[robotcore.backends]\nmade-elsewhere = made_elsewhere:Board\n")


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder from which Python imports packages."""
    monkeypatch.syspath_prepend(str(tmp_path))
    forget_packages()
    yield tmp_path
    monkeypatch.undo()
    forget_packages()


def test_a_package_for_this_version_is_loaded(packages: Path) -> None:
    install_package(packages, "robotcore>=0.1")
    assert registry.load_registered("backend", registry.BACKENDS, "made-elsewhere").name == "made-elsewhere"


@pytest.mark.parametrize("needed", [">=1000", "<0.0.1"], ids=["newer", "older"])
def test_a_package_for_another_version_is_refused_before_it_is_imported(
    packages: Path, needed: str, raises: Raises
) -> None:
    install_package(packages, f"robotcore{needed}")
    (packages / "made_elsewhere.py").write_text("raise RuntimeError('imported')")
    with raises(
        BackendMissingError, "robotcore-version", package="made-elsewhere", needed=needed, hide=[read_version()]
    ):
        load_backend("made-elsewhere")
