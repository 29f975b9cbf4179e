"""Preflight: apps and backends that fail before the first run."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore import RunRequest
from robotcore.errors import BackendError, BehaviourError, UnknownNameError, UsageError
from robotcore.sweep import LocalEngine, Sweep, run_sweep
from robotcore.sweep.preflight import preflight
from tests.robotcore.sweep.conftest import AppFile, make_sweep
from tests.texts import Raises


@pytest.mark.slow
@pytest.mark.parametrize(
    "head, kind",
    [
        ("os._exit(0)", "app-ends-process"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", "app-ends-process"),
        ("while True: pass", "app-ends-process"),
    ],
)
def test_an_app_that_cannot_be_imported_is_refused_by_its_file(
    app_file: AppFile, head: str, kind: str, raises: Raises
) -> None:
    app = app_file(head=head)
    with raises(UsageError, kind, app=app, step="imported"):
        preflight(make_sweep(app), load_s=0.5)


@pytest.mark.slow
@pytest.mark.parametrize(
    "app, judge, has_verify",
    [("green-search", None, True), ("mark-green", None, False), ("mark-green", "green-search", True)],
)
def test_the_preflight_reports_whether_runs_can_be_verified(app: str, judge: str | None, has_verify: bool) -> None:
    assert preflight(Sweep(RunRequest(app, judge=judge), seeds=(1,))) is has_verify


@pytest.mark.slow
@pytest.mark.parametrize("name", ["drivers", "apps"])
def test_a_module_beside_an_app_may_have_the_name_of_a_package(app_file: AppFile, name: str) -> None:
    app = Path(app_file())
    app.with_name(f"{name}.py").touch()
    sweep = make_sweep(str(app))
    preflight(replace(sweep, request=replace(sweep.request, judge="green-search")))


@pytest.mark.slow
def test_standard_input_is_empty_during_an_import(app_file: AppFile, raises: Raises) -> None:
    with raises(BehaviourError, "app-not-importable"):
        preflight(make_sweep(app_file(head="input()")))


@pytest.mark.slow
def test_an_error_at_import_comes_with_its_traceback(app_file: AppFile, raises: Raises) -> None:
    with raises(BehaviourError, "app-not-importable") as raised:
        preflight(make_sweep(app_file(head="1 / 0")))
    assert 'odd.py", line 5, in <module>\n    1 / 0' in raised.value.traceback


@pytest.mark.slow
def test_a_backend_that_ends_the_process_is_refused(app_file: AppFile, raises: Raises) -> None:
    app = Path(app_file())
    app.write_text(app.read_text() + "\n    stopping = property(lambda self: os._exit(7))\n")
    with raises(BackendError, "backend-ends-process", backends=["kinematic"]):
        preflight(make_sweep(str(app)))


@pytest.mark.slow
def test_the_process_of_the_sweep_does_not_import_the_app(app_file: AppFile, tmp_path: Path) -> None:
    importers = tmp_path / "importers"
    app = app_file("os._exit(0)", head=f"print(os.getpid(), file=open({str(importers)!r}, 'a'))")
    run_sweep(make_sweep(app, seeds=1), LocalEngine(1), tmp_path / "out")
    assert importers.read_text()
    assert str(os.getpid()) not in importers.read_text().split()


@pytest.mark.slow
@pytest.mark.parametrize(
    "request_, kind",
    [(RunRequest("green-serch"), "unknown-app"), (RunRequest("green-search", options={"a": "1"}), "unknown-option")],
    ids=["app", "option"],
)
def test_a_mistake_that_the_check_finds_is_refused(request_: RunRequest, kind: str, raises: Raises) -> None:
    with raises(UnknownNameError, kind):
        preflight(Sweep(request_))
