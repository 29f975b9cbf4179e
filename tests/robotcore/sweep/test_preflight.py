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
from robotcore.errors import BackendError, BehaviourError, UnknownNameError, UnmetNeedError, UsageError
from robotcore.sweep import LocalEngine, Sweep, run_sweep
from robotcore.sweep.preflight import preflight
from tests.robotcore.sweep.conftest import SWEEP, AppFile, sweep_of
from tests.texts import CheckText, Raises


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
        preflight(sweep_of(app), load_s=0.5)


@pytest.mark.parametrize("head", ["exit()", "exit(3)"])
def test_an_app_that_calls_exit_at_import_is_refused(app_file: AppFile, head: str, check_text: CheckText) -> None:
    with pytest.raises(UsageError) as raised:
        preflight(sweep_of(app_file(head=head)), load_s=0.5)
    check_text(raised.value)


def test_an_app_that_hangs_while_it_is_made_is_reported_so(app_file: AppFile, raises: Raises) -> None:
    app = Path(app_file())
    app.write_text(app.read_text() + "\n    def __init__(self):\n        Event().wait()\n")
    with raises(UsageError, "app-hangs", step="made"):
        preflight(sweep_of(str(app)), load_s=0.5)


@pytest.mark.parametrize("name", ["drivers", "apps"])
def test_a_module_beside_an_app_may_be_called_as_a_package_of_ours_is(app_file: AppFile, name: str) -> None:
    app = Path(app_file())
    app.with_name(f"{name}.py").touch()
    sweep = sweep_of(str(app))
    preflight(replace(sweep, request=replace(sweep.request, judge="green-search")))


def test_an_app_that_asks_for_input_gets_none(app_file: AppFile) -> None:
    with pytest.raises(BehaviourError, match=r"odd\.py cannot be imported: EOFError"):
        preflight(sweep_of(app_file(head="input()")))


def test_what_an_app_raises_at_import_comes_with_its_traceback(app_file: AppFile) -> None:
    with pytest.raises(BehaviourError, match=r"odd\.py cannot be imported: ZeroDivisionError") as raised:
        preflight(sweep_of(app_file(head="1 / 0")))
    assert 'odd.py", line 5, in <module>\n    1 / 0' in raised.value.traceback


def test_an_error_of_the_apps_own_is_reported_in_its_words(app_file: AppFile) -> None:
    head = "from robotcore.errors import UsageError\nclass Own(UsageError): pass\nraise Own('too fast')"
    with pytest.raises(BehaviourError, match=r"odd\.py cannot be imported: Own: too fast"):
        preflight(sweep_of(app_file(head=head)))
    app = Path(app_file(head=head.replace("raise Own", "words = str")))
    app.write_text(app.read_text() + "\n    def __init__(self):\n        raise Own('too fast')\n")
    with pytest.raises(UsageError, match=r"^too fast$"):
        preflight(sweep_of(str(app)))


def test_a_judge_is_tried_as_an_app_is(app_file: AppFile, tmp_path: Path, raises: Raises) -> None:
    judge = tmp_path / "judge.py"
    judge.write_text("import os; os._exit(0)")
    sweep = sweep_of(app_file())
    with raises(UsageError, "app-ends-process", app=f"{judge}:Strict"):
        preflight(replace(sweep, request=replace(sweep.request, judge=f"{judge}:Strict")))


@pytest.mark.parametrize(
    "sweep, error, status",
    [
        (Sweep(RunRequest("green-serch")), UnknownNameError, 2),
        (Sweep(RunRequest("green-search", robot="lookout")), UnmetNeedError, 2),
        (Sweep(RunRequest("green-search", settings={"speed_m_s": "fast"})), UsageError, 2),
    ],
)
def test_what_is_refused_is_refused_as_it_is_here(sweep: Sweep, error: type[UsageError], status: int) -> None:
    with pytest.raises(error) as here:
        sweep.check()
    with pytest.raises(error) as there:
        preflight(sweep)
    assert type(here.value) is type(there.value)
    assert str(here.value) == str(there.value)
    assert there.value.exit_status == status


def test_a_process_that_dies_after_the_app_was_made_is_not_the_fault_of_its_import(
    app_file: AppFile, raises: Raises
) -> None:
    app = Path(app_file())
    app.write_text(app.read_text() + "\n    stopping = property(lambda self: os._exit(7))\n")
    with raises(BackendError, "backend-died", backends=["kinematic"]):
        preflight(sweep_of(str(app)))


@pytest.mark.parametrize("deed", ["pass", "os._exit(0)", "1 / 0"])
def test_nothing_of_the_app_is_imported_in_the_process_of_the_sweep(
    app_file: AppFile, tmp_path: Path, deed: str
) -> None:
    importers = tmp_path / "importers"
    app = app_file(deed, head=f"print(os.getpid(), file=open({str(importers)!r}, 'a'))")
    run_sweep(sweep_of(app, seeds=1), LocalEngine(1), tmp_path / "out")
    assert importers.read_text()
    assert str(os.getpid()) not in importers.read_text().split()


def test_ctrl_c_in_the_middle_of_it_ends_both_processes_in_a_line(app_file: AppFile, tmp_path: Path) -> None:
    note = tmp_path / "child"
    deed = f"open({str(note)!r}, 'w').write(str(os.getpid())); os.kill({SWEEP}, signal.SIGINT); Event().wait()"
    done = subprocess.run(
        [sys.executable, "-m", "robotcore", "sweep", app_file(head=deed), "--out", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr.strip()) == (-signal.SIGINT, "error: interrupted by SIGINT")
    with pytest.raises(ProcessLookupError):
        os.kill(int(note.read_text()), 0)
