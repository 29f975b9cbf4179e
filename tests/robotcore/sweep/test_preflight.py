"""Preflight: apps and backends that fail before the first run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore import RunRequest
from robotcore.errors import BackendError, BehaviourError, UnknownNameError, UsageError
from robotcore.sweep import LocalEngine, Sweep, run_sweep
from robotcore.sweep.preflight import preflight
from tests.robotcore.sweep.conftest import SWEEP_ID, AppFile, make_sweep
from tests.texts import CheckText, Raises


@pytest.mark.slow
@pytest.mark.parametrize(
    "head, kind",
    [
        ("os._exit(0)", "app-ends-process"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", "app-ends-process"),
        ("while True: pass", "app-hangs"),
    ],
)
def test_an_app_that_cannot_be_imported_is_refused_by_its_file(
    app_file: AppFile, head: str, kind: str, raises: Raises
) -> None:
    app = app_file(head=head)
    with raises(UsageError, kind, app=app, step="imported"):
        preflight(make_sweep(app), load_s=0.5)


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


def test_standard_input_is_empty_during_an_import(app_file: AppFile, raises: Raises) -> None:
    with raises(BehaviourError, "app-not-importable"):
        preflight(make_sweep(app_file(head="input()")))


def test_an_error_at_import_comes_with_its_traceback(app_file: AppFile, raises: Raises) -> None:
    with raises(BehaviourError, "app-not-importable") as raised:
        preflight(make_sweep(app_file(head="1 / 0")))
    assert 'odd.py", line 5, in <module>\n    1 / 0' in raised.value.traceback


@pytest.mark.slow
@pytest.mark.parametrize(
    "sweep, error, status",
    [
        (Sweep(RunRequest("green-serch")), UnknownNameError, 2),
        (Sweep(RunRequest("green-search", settings={"speed_m_s": "fast"})), UsageError, 2),
    ],
)
def test_the_error_equals_that_of_a_check_in_this_process(sweep: Sweep, error: type[UsageError], status: int) -> None:
    with pytest.raises(error) as expected:
        sweep.check()
    with pytest.raises(error) as received:
        preflight(sweep)
    assert type(expected.value) is type(received.value)
    assert str(expected.value) == str(received.value)
    assert received.value.exit_status == status


def test_a_backend_that_ends_the_process_is_refused(app_file: AppFile, raises: Raises) -> None:
    app = Path(app_file())
    app.write_text(app.read_text() + "\n    stopping = property(lambda self: os._exit(7))\n")
    with raises(BackendError, "backend-died", backends=["kinematic"]):
        preflight(make_sweep(str(app)))


@pytest.mark.slow
@pytest.mark.parametrize("code", ["pass", "os._exit(0)", "1 / 0"])
def test_the_process_of_the_sweep_does_not_import_the_app(app_file: AppFile, tmp_path: Path, code: str) -> None:
    importers = tmp_path / "importers"
    app = app_file(code, head=f"print(os.getpid(), file=open({str(importers)!r}, 'a'))")
    run_sweep(make_sweep(app, seeds=1), LocalEngine(1), tmp_path / "out")
    assert importers.read_text()
    assert str(os.getpid()) not in importers.read_text().split()


@pytest.mark.slow
def test_ctrl_c_during_the_preflight_ends_both_processes(
    app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    id_file = tmp_path / "child"
    code = f"open({str(id_file)!r}, 'w').write(str(os.getpid())); os.kill({SWEEP_ID}, signal.SIGINT); Event().wait()"
    done = subprocess.run(
        [sys.executable, "-m", "robotcore", "sweep", app_file(head=code), "--out", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == -signal.SIGINT
    check_text(done.stderr)
    with pytest.raises(ProcessLookupError):
        os.kill(int(id_file.read_text()), 0)
