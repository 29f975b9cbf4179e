from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest

from apps.green_search import GreenSearch
from robotcore.sweep import Sweep, fingerprint
from robotcore.sweep.fingerprint import code_digest
from robotcore.sweep.ownfiles import own_files
from tests.robotcore.sweep.conftest import AppFile, sweep_of

REFLEX = """
from apps.green_search import GreenSearch

class Reflex(GreenSearch):
    ...
"""


def _digest(sweep: Sweep) -> str:
    return fingerprint.digest(fingerprint.parts(sweep))


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of somebody's, with an app two folders down; that app is what every name of an app stands for."""
    root = tmp_path / "my_robots"
    (root / "apps").mkdir(parents=True)
    (root / "__init__.py").touch()
    (root / "gains.py").write_text("GAIN = 1\n")
    (root / "apps" / "__init__.py").touch()
    (root / "apps" / "reflex.py").write_text(REFLEX)
    monkeypatch.syspath_prepend(tmp_path)
    app = import_module("my_robots.apps.reflex").Reflex
    monkeypatch.setattr(fingerprint, "load_app", lambda name: app)
    yield root
    for name in ("my_robots", "my_robots.apps", "my_robots.apps.reflex"):
        del sys.modules[name]
    fingerprint._package_digest.cache_clear()


def test_a_module_beside_the_folder_of_the_app_counts(package: Path) -> None:
    before = code_digest(["reflex"], (), ())
    (package / "gains.py").write_text("GAIN = 2\n")
    fingerprint._package_digest.cache_clear()
    assert code_digest(["reflex"], (), ()) != before


@pytest.mark.parametrize(
    "module, package",
    [
        ("my_robots.apps.reflex", "my_robots"),
        ("reflex", "reflex"),
        (GreenSearch.__module__, "apps"),
        ("drivers.kinematic.backend", "drivers.kinematic"),
        ("acme.drivers.arm.backend", "acme"),
    ],
)
def test_code_counts_by_its_outermost_package_but_drivers_one_by_one(module: str, package: str) -> None:
    assert fingerprint._package(module) == package


def test_a_judge_counts_with_what_is_beside_it(app_file: AppFile, tmp_path: Path) -> None:
    judge = tmp_path / "judge" / "strict.py"
    judge.parent.mkdir()
    judge.write_text("LIMIT = 1\n")
    judge.with_name("helper.py").touch()
    sweep = sweep_of(app_file())
    judged = replace(sweep, request=replace(sweep.request, judge=f"{judge}:Strict"))
    assert set(own_files(judged)) - set(own_files(sweep)) == {judge, judge.with_name("helper.py")}
    before = _digest(judged)
    judge.write_text("LIMIT = 2\n")
    assert len({before, _digest(judged), _digest(sweep)}) == 3


def test_what_cannot_be_imported_is_no_file_of_an_app(app_file: AppFile) -> None:
    """Emacs locks a file with a link that leads nowhere, macOS keeps what a foreign disk cannot in a second file."""
    app = Path(app_file())
    app.with_name(".#odd.py").symlink_to("somebody@somewhere.1234")
    app.with_name("._odd.py").touch()
    app.with_name("notes.py").mkdir()
    app.with_name("helper.py").touch()
    assert {file.name for file in own_files(sweep_of(str(app)))} == {"odd.py", "helper.py"}
