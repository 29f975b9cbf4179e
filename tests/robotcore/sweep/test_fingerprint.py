"""Fingerprints of a sweep, and ``sweep.json``."""

from __future__ import annotations

import platform
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from apps.green_search import GreenSearch
from robotcore.errors import UsageError
from robotcore.sweep import Results, Sweep, fingerprint
from robotcore.sweep.fingerprint import MANIFEST, read_own_files
from tests.robotcore.description.courses import write_course
from tests.robotcore.sweep.conftest import AppFile, make_sweep
from tests.texts import CheckText, Raises

SWEEP = make_sweep("green-search", seeds=3)


def _digest(sweep: Sweep) -> str:
    return fingerprint.compute_digest(fingerprint.collect_dependencies(sweep))


def test_each_source_file_of_a_package_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = ModuleType("my_robots")
    package.__path__ = [str(tmp_path)]
    monkeypatch.setitem(sys.modules, "my_robots", package)
    (tmp_path / "apps").mkdir()
    digests = set()
    for name, text in (("gains.py", "1"), ("gains.py", "2"), ("apps/gains.py", "2"), ("robot.toml", "")):
        (tmp_path / name).write_text(text)
        digests.add(fingerprint._compute_package_digest.__wrapped__("my_robots"))
    (tmp_path / "notes.txt").touch()
    assert len(digests) == 4
    assert fingerprint._compute_package_digest.__wrapped__("my_robots") in digests


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
def test_a_module_counts_by_its_outermost_package_or_its_driver(module: str, package: str) -> None:
    assert fingerprint._find_package(module) == package


def test_the_picture_on_the_floor_of_a_world_counts(tmp_path: Path) -> None:
    sweep = make_sweep("green-search", worlds=(write_course(tmp_path),))
    assert set(read_own_files(sweep)) == {tmp_path / "course.toml", tmp_path / "course.png"}
    before = _digest(sweep)
    write_course(tmp_path, np.zeros((4, 6, 3), np.uint8))
    assert _digest(sweep) != before


def test_a_file_that_an_option_of_the_backend_names_counts(tmp_path: Path) -> None:
    truth = tmp_path / "truth.toml"
    truth.touch()
    sweep = make_sweep("green-search")
    options = {"truth": str(truth), "simulator": "kinematic"}
    sweep = replace(sweep, request=replace(sweep.request, options=options))
    assert set(read_own_files(sweep)) == {truth}


def test_a_judge_counts_with_the_modules_beside_it(app_file: AppFile, tmp_path: Path) -> None:
    judge = tmp_path / "judge" / "strict.py"
    judge.parent.mkdir()
    judge.write_text("LIMIT = 1\n")
    judge.with_name("helper.py").touch()
    judge.with_name(".#strict.py").symlink_to("somebody@somewhere.1234")  # Emacs locks a file with a broken link
    judge.with_name("notes.py").mkdir()
    sweep = make_sweep(app_file())
    judged = replace(sweep, request=replace(sweep.request, judge=f"{judge}:Strict"))
    assert set(read_own_files(judged)) - set(read_own_files(sweep)) == {judge, judge.with_name("helper.py")}
    before = _digest(judged)
    judge.write_text("LIMIT = 2\n")
    assert len({before, _digest(judged), _digest(sweep)}) == 3


def _change_request(sweep: Sweep = SWEEP, **changes: Any) -> Sweep:
    return replace(sweep, request=replace(sweep.request, **changes))


def _begin(directory: Path, sweep: Sweep = SWEEP) -> Path:
    with Results(sweep, directory):
        return directory / MANIFEST


def _list_changes(directory: Path, sweep: Sweep = SWEEP) -> list[str]:
    """Return the changes that the error about a folder of another sweep lists."""
    with pytest.raises(UsageError) as refused, Results(sweep, directory):
        pass
    assert (refused.value.kind, refused.value.fields["directory"]) == ("other-results", str(directory))
    changes = refused.value.fields["changes"]
    assert isinstance(changes, list)
    return changes


@pytest.mark.parametrize(
    "old, new",
    [
        (_change_request(settings={"speed_m_s": "0.3"}), _change_request(settings={"speed_m_s": "0.2"})),
        (SWEEP, _change_request(settings={"speed_m_s": "0.2"})),
        (SWEEP, _change_request(randomise=True, rate_hz=10.0)),
        (_change_request(judge="green-search"), SWEEP),
        (_change_request(settings={f"key{n}": "1" for n in range(7)}), SWEEP),
    ],
    ids=["other setting", "new setting", "two fields", "no judge", "many"],
)
def test_changes_of_the_request_are_listed_by_key_and_leave_the_folder_unchanged(
    tmp_path: Path, old: Sweep, new: Sweep, raises: Raises
) -> None:
    before = _begin(tmp_path, old).read_bytes()
    with raises(UsageError, "other-results", directory=str(tmp_path)), Results(new, tmp_path):
        pass
    assert {file.name for file in tmp_path.iterdir()} == {MANIFEST, "results.jsonl"}
    assert (tmp_path / MANIFEST).read_bytes() == before


def test_changes_of_the_users_files_are_listed_by_path(
    app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    sweep, folder = make_sweep(app_file()), tmp_path / "out"
    monkeypatch.chdir(tmp_path)
    _begin(folder, sweep)
    app_file("self.ticks += 1")
    check_text("\n".join(_list_changes(folder, sweep)))
    app_file()
    (tmp_path / "app" / "helper.py").touch()
    check_text("\n".join(_list_changes(folder, sweep)))
    monkeypatch.chdir(tmp_path / "app")
    (tmp_path / "app" / "helper.py").unlink()
    _begin(folder, sweep)


def test_changes_of_code_and_libraries_are_listed_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    _begin(tmp_path)
    with monkeypatch.context() as updated:
        updated.setattr(fingerprint, "libraries", lambda _: {"numpy": "2.9", "python": platform.python_version()})
        changes = _list_changes(tmp_path)
    check_text(changes[0], hide=[np.__version__])
    assert changes[1].startswith("opencv-python")
    monkeypatch.setattr(fingerprint, "_compute_package_digest", lambda name: f"changed {name}")
    check_text("\n".join(_list_changes(tmp_path)[:2]))


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b"\xff"])
def test_a_damaged_manifest_is_refused_and_fresh_replaces_it(
    tmp_path: Path, content: bytes, check_text: CheckText
) -> None:
    manifest = _begin(tmp_path)
    whole = manifest.read_bytes()
    manifest.write_bytes(content)
    check_text("\n".join(_list_changes(tmp_path)))
    with Results(SWEEP, tmp_path, deletes_old_results=True):
        assert manifest.read_bytes() == whole
