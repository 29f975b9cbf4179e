"""test_plugins."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

import pytest

from robotcore import plugins as registry
from robotcore.errors import BackendMissingError, UnknownNameError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.plugins import app_names, backend_names
from robotcore.runtime.apps import app_name, load_app

Register = Callable[..., None]


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Iterator[Register]:
    """Stand in for what is installed: entry points of both groups."""

    def install(**values: str) -> None:
        registry._points.cache_clear()
        monkeypatch.setattr(
            registry,
            "entry_points",
            lambda group: [EntryPoint(name.replace("_", "-"), value, group) for name, value in values.items()],
        )

    yield install
    monkeypatch.undo()
    registry._points.cache_clear()


def test_everything_that_is_registered_can_be_loaded() -> None:
    assert [load_backend(name).name for name in backend_names()] == backend_names()
    assert all(load_app(name).step for name in app_names())


def test_names_are_those_of_the_entry_points(register: Register) -> None:
    register(zebra="a:B", ape="c:D")
    assert backend_names() == app_names() == ["ape", "zebra"]


def test_a_name_with_an_underscore_is_the_one_with_a_hyphen(register: Register) -> None:
    register(null_app="tests.robotcore.fakes:Deed")
    assert load_app("null_app") is load_app("null-app")
    assert app_name("null_app") == "null-app"
    assert app_name("my_apps/null_app.py") == "my_apps/null_app.py"


def test_an_unknown_name_offers_the_nearest(register: Register) -> None:
    register(kinematic="a:B")
    with pytest.raises(UnknownNameError, match=r"unknown backend 'kinematik'. Did you mean 'kinematic'\?"):
        load_backend("kinematik")


@pytest.mark.parametrize("name, what", [("my_apps", "a folder"), ("my_apps/notes.txt", "no .py file")])
def test_what_is_there_and_no_app_file_is_reported_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, what: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_apps").mkdir()
    (tmp_path / "my_apps" / "notes.txt").touch()
    with pytest.raises(UsageError, match=rf"^{name} is {what}, and no app. Name an app \(robotcore apps\), or the .py"):
        load_app(name)


def test_an_app_is_not_hidden_by_a_folder_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, register: Register
) -> None:
    register(null_app="tests.robotcore.fakes:Deed")
    monkeypatch.chdir(tmp_path)
    for name in ("null-app", "null_app"):
        (tmp_path / name).mkdir()
        assert load_app(name).__name__ == "Deed"


def test_a_project_that_is_not_installed_says_what_to_do(register: Register) -> None:
    register()
    with pytest.raises(UsageError, match=r"no app is registered. Install the project first"):
        load_app("green-search")


@pytest.mark.parametrize("value", ["no_such_module:Thing", "tests.robotcore.fakes:NoSuchThing"])
def test_what_cannot_be_loaded_is_reported_with_its_place_and_the_cause(register: Register, value: str) -> None:
    register(broken=value)
    with pytest.raises(
        BackendMissingError, match=rf"the backend 'broken' \({value}\) cannot be loaded: .*\w"
    ) as raised:
        load_backend("broken")
    assert raised.value.__cause__


def test_an_app_in_a_file_is_loaded_from_it(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("from robotcore import Behaviour, Status\nclass Mine(Behaviour):\n    def step(self, robot): ...\n")
    assert load_app(str(file)).__name__ == "Mine"


def test_groups_are_those_of_the_installed_project() -> None:
    assert {point.name for point in entry_points(group=registry.BACKENDS)} >= {"kinematic", "mock", "pybullet"}
    assert {point.name for point in entry_points(group=registry.APPS)} >= {"green-search", "mark-green"}
    assert {point.name for point in entry_points(group=registry.FAULTS)} >= {"drop", "noise.camera", "stall"}
