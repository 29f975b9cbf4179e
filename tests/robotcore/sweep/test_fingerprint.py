"""Fingerprints of a sweep, and ``sweep.json``."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from apps.green_search import GreenSearch
from robotcore.errors import UsageError
from robotcore.sweep import Results, Sweep, fingerprint
from robotcore.sweep.fingerprint import MANIFEST, code_digest, read_own_files
from tests.robotcore.sweep.conftest import AppFile, sweep_of
from tests.texts import Raises

REFLEX = """
from apps.green_search import GreenSearch

class Reflex(GreenSearch):
    ...
"""

SWEEP = sweep_of("green-search", seeds=3)


def _digest(sweep: Sweep) -> str:
    return fingerprint.compute_digest(fingerprint.collect_dependencies(sweep))


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
    assert fingerprint._find_package(module) == package


def test_a_judge_counts_with_what_is_beside_it(app_file: AppFile, tmp_path: Path) -> None:
    judge = tmp_path / "judge" / "strict.py"
    judge.parent.mkdir()
    judge.write_text("LIMIT = 1\n")
    judge.with_name("helper.py").touch()
    sweep = sweep_of(app_file())
    judged = replace(sweep, request=replace(sweep.request, judge=f"{judge}:Strict"))
    assert set(read_own_files(judged)) - set(read_own_files(sweep)) == {judge, judge.with_name("helper.py")}
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
    assert {file.name for file in read_own_files(sweep_of(str(app)))} == {"odd.py", "helper.py"}


def _asking(sweep: Sweep = SWEEP, **changes: Any) -> Sweep:
    return replace(sweep, request=replace(sweep.request, **changes))


def _begun(directory: Path, sweep: Sweep = SWEEP) -> Path:
    with Results(sweep, directory):
        return directory / MANIFEST


def _changes(directory: Path, sweep: Sweep = SWEEP) -> list[str]:
    """Return what has changed, by the error that refuses the folder."""
    with pytest.raises(UsageError) as refused, Results(sweep, directory):
        pass
    assert (refused.value.kind, refused.value.fields["directory"]) == ("other-results", str(directory))
    changes = refused.value.fields["changes"]
    assert isinstance(changes, list)
    return changes


@pytest.mark.parametrize(
    "then, now, changes",
    [
        (
            _asking(settings={"speed_m_s": "0.3"}),
            _asking(settings={"speed_m_s": "0.2"}),
            ["settings.speed_m_s is 0.2, was 0.3"],
        ),
        (SWEEP, _asking(settings={"speed_m_s": "0.2"}), ["settings.speed_m_s is 0.2, was not given"]),
        (SWEEP, _asking(randomise=True, rate_hz=10.0), ["randomise is true, was false", "rate_hz is 10.0, was 20.0"]),
        (_asking(judge="green-search"), SWEEP, ["judge is not given, was green-search"]),
        (SWEEP, replace(SWEEP, worlds=("open", "arena")), ["worlds is arena, open, was open"]),
    ],
)
def test_what_else_was_asked_for_is_named_by_key(tmp_path: Path, then: Sweep, now: Sweep, changes: list[str]) -> None:
    _begun(tmp_path, then)
    assert _changes(tmp_path, now) == changes


def test_what_is_asked_for_in_another_order_is_the_same(tmp_path: Path) -> None:
    _begun(tmp_path, sweep_of("green-search", worlds=("open", "arena")))
    _begun(tmp_path, sweep_of("green-search", worlds=("arena", "open")))


def test_files_of_ones_own_are_named_by_name(
    app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep, folder = sweep_of(app_file()), tmp_path / "out"
    monkeypatch.chdir(tmp_path)
    _begun(folder, sweep)
    app_file("self.ticks += 1")
    assert _changes(folder, sweep) == ["your file app/odd.py has changed"]
    app_file()
    (tmp_path / "app" / "helper.py").touch()
    assert _changes(folder, sweep) == ["your file app/helper.py is new"]
    monkeypatch.chdir(tmp_path / "app")
    (tmp_path / "app" / "helper.py").unlink()
    _begun(folder, sweep)


def test_code_and_libraries_are_named_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _begun(tmp_path)
    with monkeypatch.context() as updated:
        updated.setattr(fingerprint, "libraries", lambda _: {"numpy": "2.9", "python": platform.python_version()})
        changes = _changes(tmp_path)
    assert changes[0] == f"numpy is 2.9, was {np.__version__}"
    assert changes[1].startswith("opencv-python")
    monkeypatch.setattr(fingerprint, "_package_digest", lambda name: f"changed {name}")
    assert _changes(tmp_path)[:2] == ["the code of apps has changed", "the code of drivers.kinematic has changed"]


def test_many_changes_are_reported_in_a_few_words(tmp_path: Path, raises: Raises) -> None:
    _begun(tmp_path, _asking(settings={f"key{n}": "1" for n in range(7)}))
    with raises(UsageError, "other-results"), Results(SWEEP, tmp_path):
        pass


@pytest.mark.parametrize(
    "content", [b"", b"[]", b"{}", b"\xff", b'{"asked": 1, "code": 2, "files": 3, "libraries": 4}']
)
def test_a_file_that_somebody_has_spoilt_is_reported_and_forgotten_with_the_rest(
    tmp_path: Path, content: bytes
) -> None:
    spec = _begun(tmp_path)
    whole = spec.read_bytes()
    spec.write_bytes(content)
    assert _changes(tmp_path) == ["its sweep.json cannot be read"]
    with Results(SWEEP, tmp_path, fresh=True):
        assert spec.read_bytes() == whole


def test_it_tells_which_seeds_were_asked_for_last(tmp_path: Path) -> None:
    spec = _begun(tmp_path)
    assert json.loads(spec.read_text())["seeds"] == "1-3"
    _begun(tmp_path, replace(SWEEP, seeds=(5, 7, 8, 9, 2)))
    assert json.loads(spec.read_text())["seeds"] == "5,7-9,2"


def test_a_refusal_leaves_everything_as_it_was(tmp_path: Path) -> None:
    before = _begun(tmp_path).read_bytes()
    _changes(tmp_path, _asking(rate_hz=10.0))
    assert {file.name for file in tmp_path.iterdir()} == {MANIFEST, "results.jsonl"}
    assert (tmp_path / MANIFEST).read_bytes() == before
