from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from select import select
from typing import Any

import pytest

from robotcore import Outcome, RunRequest, RunResult, run
from robotcore.runtime.plan import Plan
from robotcore.sweep import LocalEngine, Record, Sweep, run_sweep
from robotcore.sweep.record import MAX_RESULT_TEXT
from robotcore.sweep.spec import format_command
from tests.robotcore.sweep.conftest import SWEEP, AppFile, sweep_of

OWN_SESSION = "__import__('subprocess').Popen(['sleep', '60'], start_new_session=True)"
PIPES = "[int(fd.name) for fd in __import__('pathlib').Path('/proc/self/fd').iterdir() if fd.is_socket()]"
"""Of a worker, the one to its parent among them: in what an app does."""


def _records(sweep: Sweep, engine: LocalEngine) -> dict[int | None, Record]:
    return {record.result.seed: record for record, _ in engine.perform(sweep, sweep.requests())}


def test_runs_come_out_as_they_do_one_by_one(app_file: AppFile) -> None:
    sweep = sweep_of(app_file(), seeds=3)
    records = _records(sweep, LocalEngine(2))
    for request in sweep.requests():
        alone = json.loads(run(request).to_json())
        swept = json.loads(records[request.seed].result.to_json())
        assert swept.pop("wall_time_s") >= 0
        del alone["wall_time_s"]
        assert swept == alone


def test_a_path_has_a_point_every_half_second() -> None:
    sweep = Sweep(RunRequest("avoid-obstacles", settings={"duration_s": 2.0}), worlds=("open",), seeds=(1,))
    path = _records(sweep, LocalEngine(1))[1].path
    assert path
    assert [time for time, _, _ in path] == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert path[0][1:] != path[-1][1:]


def test_an_app_that_raises_fails_each_run_with_its_words(app_file: AppFile) -> None:
    sweep = sweep_of(app_file("1 / 0"))
    for ended in LocalEngine(1).perform(sweep, sweep.requests()):
        assert ended.record.result.outcome is Outcome.ERROR
        assert ended.record.result.reason == "Odd raised ZeroDivisionError: division by zero"
        assert ended.picture
        assert ended.picture.startswith(b"\x89PNG")


def test_a_worker_that_dies_costs_its_run_alone(app_file: AppFile, tmp_path: Path) -> None:
    deed = f"open({str(tmp_path / 'once')!r}, 'x'); os.kill(os.getpid(), signal.SIGKILL)"
    sweep = sweep_of(app_file(f"(not os.path.exists({str(tmp_path / 'once')!r})) and exec({deed!r})"), seeds=3)
    results = [record.result for record in _records(sweep, LocalEngine(1)).values()]
    (died,) = [result for result in results if result.outcome is Outcome.ERROR]
    assert died.reason == "the worker process died: SIGKILL"
    assert (died.app, died.robot, died.world) == (sweep.request.app, "rover", "open")
    assert [result.outcome for result in results].count(Outcome.SUCCESS) == 2


@pytest.mark.parametrize(
    "deed, status", [("os._exit(0)", 0), ("os._exit(1)", 1), ("os.kill(os.getpid(), signal.SIGTERM)", 143)]
)
def test_a_worker_that_is_ended_is_reported_at_once_by_the_exit_status(
    app_file: AppFile, deed: str, status: int
) -> None:
    (record,) = _records(sweep_of(app_file(deed), seeds=1), LocalEngine(1, wall_timeout_s=1e6)).values()
    assert record.result.reason == f"the worker process died: exit status {status}"


@pytest.mark.parametrize("start", ["os.system('sleep 60 &')", "os.fork() or Event().wait()"])
def test_a_worker_that_ends_is_reported_at_once_whatever_it_has_started(
    app_file: AppFile, tmp_path: Path, start: str
) -> None:
    group = tmp_path / "group"
    sweep = sweep_of(app_file(f"open({str(group)!r}, 'w').write(str(os.getpgrp())); {start}; os._exit(3)"), seeds=1)
    try:
        (record,) = _records(sweep, LocalEngine(1, wall_timeout_s=10.0)).values()
    finally:
        with suppress(ProcessLookupError):
            os.killpg(int(group.read_text()), signal.SIGKILL)
    assert record.result.reason == "the worker process died: exit status 3"


def test_a_copy_that_an_app_makes_of_its_process_answers_for_no_run(app_file: AppFile) -> None:
    sweep = sweep_of(app_file("os.fork() or Event().wait(0.02)"), seeds=20)
    seeds = [ended.record.result.seed for ended in LocalEngine(1).perform(sweep, sweep.requests())]
    assert seeds == list(sweep.seeds)


def test_the_states_of_an_app_may_be_an_enumeration_of_its_own(app_file: AppFile) -> None:
    app = Path(app_file(head="from enum import Enum\nclass Phase(str, Enum):\n    GO = 'go'"))
    app.write_text(app.read_text() + "\n    milestones = (Phase.GO,)\n    state = Phase.GO\n")
    (record,) = _records(sweep_of(str(app), seeds=1), LocalEngine(1)).values()
    assert (record.result.outcome, list(record.result.milestones)) == (Outcome.SUCCESS, ["go"])


def test_an_app_that_exits_has_raised(app_file: AppFile) -> None:
    (record,) = _records(sweep_of(app_file("raise SystemExit(0)"), seeds=1), LocalEngine(1)).values()
    assert record.result.reason == "Odd raised SystemExit: 0"


def test_a_worker_may_die_of_a_signal_without_a_name(app_file: AppFile) -> None:
    sweep = sweep_of(app_file("os.kill(os.getpid(), signal.SIGRTMIN + 1)"), seeds=1)
    (record,) = _records(sweep, LocalEngine(1)).values()
    assert record.result.reason == f"the worker process died: signal {signal.SIGRTMIN + 1}"


def test_a_run_that_hangs_is_given_up(app_file: AppFile) -> None:
    sweep = sweep_of(app_file("Event().wait()"), seeds=1)
    (record,) = _records(sweep, LocalEngine(1, wall_timeout_s=3.0)).values()
    assert record.result.reason == "hung: no end after 3 s of wall time"
    assert (record.path, record.is_failure) == (None, True)
    assert record.result.wall_time_s >= 3.0


@pytest.mark.parametrize("judge, verified", [("green-search", False), (None, None)])
def test_a_run_that_died_is_not_verified_where_somebody_judges(
    app_file: AppFile, judge: str | None, *, verified: bool | None
) -> None:
    sweep = Sweep(RunRequest(app_file("os._exit(1)"), timeout_s=5.0, judge=judge), worlds=("open",), seeds=(1,))
    (record,) = _records(sweep, LocalEngine(1)).values()
    result = record.result
    assert (result.outcome, result.verified, result.judge) == (Outcome.ERROR, verified, judge)
    assert record.result.wall_time_s > 0.0


def test_what_a_run_that_hangs_has_started_ends_with_it(app_file: AppFile, tmp_path: Path) -> None:
    note = tmp_path / "note"
    sweep = sweep_of(app_file(f"os.system('sleep 60 & echo $! > {note}'); Event().wait()"), seeds=1)
    _records(sweep, LocalEngine(1, wall_timeout_s=3.0))
    _require_gone(int(note.read_text()))


@pytest.mark.parametrize("end, outcome", [("pass", "success"), ("os._exit(3)", "error"), ("Event().wait()", "error")])
def test_what_a_run_has_started_in_a_session_of_its_own_ends_with_the_sweep(
    app_file: AppFile, tmp_path: Path, end: str, outcome: str
) -> None:
    note = tmp_path / "note"
    sweep = sweep_of(app_file(f"open({str(note)!r}, 'w').write(str({OWN_SESSION}.pid)); {end}"), seeds=1)
    (record,) = _records(sweep, LocalEngine(1, wall_timeout_s=3.0)).values()
    assert record.result.outcome.value == outcome
    with pytest.raises(ProcessLookupError):
        os.kill(int(note.read_text()), 0)


def test_a_sweep_gives_standard_error_back_whatever_a_run_has_started(app_file: AppFile, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "robotcore", *_sweep(app_file(OWN_SESSION), tmp_path)]
    subprocess.run(command, capture_output=True, check=True, timeout=50.0)


@pytest.mark.parametrize(
    "deed",
    [
        f"[os.write(fd, b'\\xff' * 64 + b'\\n') for fd in {PIPES}]",
        f"[os.write(fd, b'\\x00\\x00\\x00\\x10') for fd in {PIPES}]",
        f"[os.write(fd, b'[' * 100_000 + b'\\n') for fd in {PIPES}]",
        f'[os.write(fd, b\'{{"result": 5, "error": null}}\\n\') for fd in {PIPES}]',
        f"[os.close(fd) for fd in {PIPES}]",
    ],
)
def test_a_run_that_writes_to_the_pipe_of_its_worker_fails_alone(app_file: AppFile, tmp_path: Path, deed: str) -> None:
    once = f"(not os.path.exists({str(tmp_path / 'once')!r})) and (open({str(tmp_path / 'once')!r}, 'x'), {deed})"
    sweep = sweep_of(app_file(once), seeds=3)
    results = [record.result for record in _records(sweep, LocalEngine(1)).values()]
    assert sorted(result.outcome.value for result in results) == ["error", "success", "success"]


FORGED_ERROR = {"result": None, "error": {"robotcore.errors": ["BackendError", ["forged"], {"exit_status": 0}]}}


def test_an_error_that_an_app_forges_fails_its_run_alone(app_file: AppFile) -> None:
    sweep = sweep_of(app_file(_forge(FORGED_ERROR)), seeds=3)
    records = _records(sweep, LocalEngine(1))
    assert [records[seed].result.outcome for seed in (1, 2, 3)] == [Outcome.ERROR] * 3
    assert all(record.result.exit_status for record in records.values())


@pytest.mark.parametrize(
    "key, value", [("seed", 2), ("app", "x.py"), ("backend", "mock"), ("robot", "lookout"), ("world", "arena")]
)
def test_a_record_of_another_run_that_an_app_forges_fails_its_run_alone(
    app_file: AppFile, key: str, value: str | int
) -> None:
    app = app_file()
    line = _forged_record(app, **{key: value})
    app_file(_forge({"result": [line, ""], "error": None}))
    (record,) = _records(sweep_of(app, seeds=1), LocalEngine(1)).values()
    assert (record.result.outcome, getattr(record.result, key) == value) == (Outcome.ERROR, False)


def test_the_command_and_the_picture_s_place_are_those_of_the_sweep_whatever_an_app_sends(app_file: AppFile) -> None:
    app = app_file()
    line = _forged_record(app)
    app_file(_forge({"result": [line, ""], "error": None}))
    sweep = sweep_of(app, seeds=1)
    (record,) = _records(sweep, LocalEngine(1)).values()
    assert (record.command, record.picture) == (format_command(next(sweep.requests())), None)


def _forged_record(app: str, /, **changed: Any) -> str:
    result = RunResult(app, "kinematic", "rover", "open", 1, Outcome.SUCCESS, exit_status=0, verified=True)
    return Record(replace(result, **changed), None, "rm -rf ~", "../../picture.png").to_json()


def _forge(answer: dict[str, Any]) -> str:
    line = json.dumps(answer).encode() + b"\n"
    return f"[os.write(fd, {line!r}) for fd in {PIPES}] and Event().wait()"


def test_long_reasons_are_cut(app_file: AppFile) -> None:
    sweep = sweep_of(app_file("raise ValueError('x' * 20_000_000)"), seeds=1)
    (record,) = _records(sweep, LocalEngine(1)).values()
    assert record.result.outcome is Outcome.ERROR
    assert len(record.to_json()) < 3 * MAX_RESULT_TEXT
    assert record.result.reason.startswith("Odd raised ValueError: xxx")
    assert record.result.reason.endswith("more characters)")


def test_a_run_without_an_end_tells_the_conditions_that_it_was_under(app_file: AppFile) -> None:
    request = RunRequest(app_file("os._exit(1)"), timeout_s=5.0, randomise=True)
    sweep = Sweep(request, worlds=("open",), seeds=(1,))
    (record,) = _records(sweep, LocalEngine(1)).values()
    assert record.result.reason == "the worker process died: exit status 1"
    assert record.result.conditions == Plan.of(next(sweep.requests())).drawn != {}


def test_the_conditions_of_an_app_that_cannot_be_imported_are_reported_too(app_file: AppFile) -> None:
    (record,) = _records(sweep_of(app_file(head="1 / 0"), seeds=1), LocalEngine(1)).values()
    assert record.result.outcome is Outcome.ERROR
    assert record.result.conditions


def test_a_run_in_a_world_that_cannot_be_drawn_has_no_conditions(app_file: AppFile, tmp_path: Path) -> None:
    world = tmp_path / "tight.toml"
    world.write_text('name = "tight"\n[floor]\nlength_m = 0.3\nwidth_m = 0.3\n')
    (record,) = _records(sweep_of(app_file(), seeds=1, worlds=(str(world),)), LocalEngine(1)).values()
    assert (record.result.outcome, record.result.conditions) == (Outcome.ERROR, {})


CTRL_C_AT_A_WORKER_S_START = """
import os, signal, sys
if "robotcore.sweep.worker" in sys.orig_argv[-1]:
    os.killpg(os.getpgid(os.getppid()), signal.SIGINT)
"""


def test_ctrl_c_while_workers_start_is_reported_once(app_file: AppFile, tmp_path: Path) -> None:
    """A terminal sends it to the whole group, in which no worker is."""
    (tmp_path / "sitecustomize.py").write_text(CTRL_C_AT_A_WORKER_S_START)
    done = subprocess.run(
        [sys.executable, "-m", "robotcore", *_sweep(app_file(), tmp_path)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
        start_new_session=True,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == -signal.SIGINT
    assert "KeyboardInterrupt" not in done.stderr
    assert "Traceback" not in done.stderr


def test_a_worker_that_has_started_hears_signals_again(app_file: AppFile) -> None:
    deed = "assert not signal.pthread_sigmask(signal.SIG_BLOCK, ())"
    assert _records(sweep_of(app_file(deed), seeds=1), LocalEngine(1))[1].result.outcome is Outcome.SUCCESS


def test_closing_stops_what_is_under_way(app_file: AppFile, tmp_path: Path) -> None:
    """No process is left: every test checks that."""
    first = tmp_path / "first"
    sweep = sweep_of(app_file(f"os.path.exists({str(first)!r}) and Event().wait(); open({str(first)!r}, 'w')"), seeds=9)
    with closing(LocalEngine(1, wall_timeout_s=1e6).perform(sweep, sweep.requests())) as ended:
        next(ended)


def test_workers_compute_with_one_thread_each(app_file: AppFile) -> None:
    deed = "assert (cv2.getNumThreads(), os.environ['OPENBLAS_NUM_THREADS']) == (1, '1')"
    sweep = sweep_of(app_file(deed, head="import cv2"), seeds=1)
    assert _records(sweep, LocalEngine(1))[1].result.outcome is Outcome.SUCCESS


def test_a_worker_does_not_outlive_a_parent_that_is_killed(app_file: AppFile, tmp_path: Path) -> None:
    note = tmp_path / "worker"
    app = app_file(f"open({str(note)!r}, 'w').write(str(os.getpid())); os.kill({SWEEP}, 9); Event().wait()")
    done = subprocess.run([sys.executable, "-m", "robotcore", *_sweep(app, tmp_path)], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL
    _require_gone(int(note.read_text()))


@pytest.mark.parametrize(
    "deed", ["print('verified')", "os.system('echo verified')", "(print('verified'), os._exit(0))"]
)
def test_what_an_app_prints_goes_to_standard_error_also_where_it_is_its_last(
    app_file: AppFile, tmp_path: Path, deed: str
) -> None:
    command = [sys.executable, "-m", "robotcore", *_sweep(app_file(deed), tmp_path), "--json"]
    env = {**os.environ, "PYTHONUNBUFFERED": ""}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
    assert len(done.stdout.splitlines()) == 1
    assert "verified\n" in done.stderr


def _sweep(app: str, folder: Path) -> list[str]:
    return ["sweep", app, "--world", "open", "--seeds", "1", "--jobs", "1", "--out", str(folder / "out")]


def _require_gone(process: int) -> None:
    with suppress(ProcessLookupError), open(os.pidfd_open(process)) as ended:  # noqa: PTH123  a process, not a path
        assert select([ended], [], [], 30.0)[0]


def test_a_sweep_goes_on_where_it_was_left(tmp_path: Path, app_file: AppFile) -> None:
    sweep = sweep_of(app_file(), seeds=3)
    first = run_sweep(sweep, _Only(1), tmp_path / "out")
    assert len(list(first.records())) == 1
    assert (tmp_path / "out" / "results.csv").exists()
    engine = _Only(9)
    second = run_sweep(sweep, engine, tmp_path / "out")
    assert len(engine.asked) == 2
    assert {record.result.seed for record in second.records()} == {1, 2, 3}


class _Only:
    """An engine that ends after some runs, in this process."""

    def __init__(self, runs: int) -> None:
        self._runs = runs
        self.asked: Sequence[RunRequest] = ()

    def perform(self, sweep: Sweep, requests: Any) -> Any:
        from robotcore.sweep.single_run import perform

        self.asked = list(requests)
        yield from map(perform, self.asked[: self._runs])
