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
from robotcore.sweep.spec import format_command
from tests.robotcore.sweep.conftest import SWEEP_ID, AppFile, make_sweep
from tests.texts import CheckText

OWN_SESSION = "__import__('subprocess').Popen(['sleep', '60'], start_new_session=True)"
PIPES = "[int(fd.name) for fd in __import__('pathlib').Path('/proc/self/fd').iterdir() if fd.is_socket()]"
"""The expression in an app for the file descriptors of its worker's pipes, one of which leads to the parent."""


def _execute(sweep: Sweep, engine: LocalEngine) -> dict[int | None, Record]:
    return {record.result.seed: record for record, _ in engine.perform(sweep, sweep.requests())}


@pytest.mark.slow
def test_a_run_of_a_sweep_has_the_result_of_a_single_run(app_file: AppFile) -> None:
    sweep = make_sweep(app_file(), seeds=3)
    records = _execute(sweep, LocalEngine(2))
    for request in sweep.requests():
        alone = json.loads(run(request).to_json())
        swept = json.loads(records[request.seed].result.to_json())
        assert swept.pop("wall_time_s") >= 0
        del alone["wall_time_s"]
        assert swept == alone


@pytest.mark.slow
def test_a_path_has_a_point_every_half_second() -> None:
    sweep = Sweep(RunRequest("avoid-obstacles", settings={"duration_s": 8.0}), worlds=("open",), seeds=(1,))
    path = _execute(sweep, LocalEngine(1))[1].path
    assert path
    assert [time for time, _, _ in path] == [tick / 2 for tick in range(17)]
    assert path[0][1:] != path[-1][1:]


@pytest.mark.slow
def test_an_app_that_raises_fails_each_run(app_file: AppFile, check_text: CheckText) -> None:
    sweep = make_sweep(app_file("1 / 0"))
    for output in LocalEngine(1).perform(sweep, sweep.requests()):
        assert output.record.result.outcome is Outcome.ERROR
        check_text(output.record.result.reason)
        assert output.picture
        assert output.picture.startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_worker_that_dies_fails_its_run_alone(app_file: AppFile, tmp_path: Path, check_text: CheckText) -> None:
    code = f"open({str(tmp_path / 'once')!r}, 'x'); os.kill(os.getpid(), signal.SIGKILL)"
    sweep = make_sweep(app_file(f"(not os.path.exists({str(tmp_path / 'once')!r})) and exec({code!r})"), seeds=3)
    results = [record.result for record in _execute(sweep, LocalEngine(1)).values()]
    (died,) = [result for result in results if result.outcome is Outcome.ERROR]
    check_text(died.reason)
    assert (died.app, died.robot, died.world) == (sweep.request.app, "rover", "open")
    assert [result.outcome for result in results].count(Outcome.SUCCESS) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    "code",
    [
        "os._exit(0)",
        "raise SystemExit(0)",
        "os.kill(os.getpid(), signal.SIGTERM)",
        "os.kill(os.getpid(), signal.SIGRTMIN + 1)",
        "os.system('sleep 60 &'), os._exit(3)",
        "os.fork() or Event().wait(), os._exit(3)",
    ],
)
def test_a_worker_that_exits_is_reported_at_once_with_its_status(
    app_file: AppFile, code: str, check_text: CheckText
) -> None:
    (record,) = _execute(make_sweep(app_file(code), seeds=1), LocalEngine(1, wall_timeout_s=1e6)).values()
    check_text(record.result.reason, hide=[signal.SIGRTMIN + 1])


@pytest.mark.slow
def test_a_process_that_an_app_forks_cannot_reply(app_file: AppFile) -> None:
    sweep = make_sweep(app_file("os.fork() or Event().wait(0.02)"), seeds=20)
    seeds = [output.record.result.seed for output in LocalEngine(1).perform(sweep, sweep.requests())]
    assert seeds == list(sweep.seeds)


@pytest.mark.slow
def test_the_states_of_an_app_may_be_an_enumeration_in_its_file(app_file: AppFile) -> None:
    app = Path(app_file(head="from enum import Enum\nclass Phase(str, Enum):\n    GO = 'go'"))
    app.write_text(app.read_text() + "\n    milestones = (Phase.GO,)\n    state = Phase.GO\n")
    (record,) = _execute(make_sweep(str(app), seeds=1), LocalEngine(1)).values()
    assert (record.result.outcome, list(record.result.milestones)) == (Outcome.SUCCESS, ["go"])


@pytest.mark.slow
def test_a_run_that_hangs_is_ended(app_file: AppFile, check_text: CheckText) -> None:
    sweep = make_sweep(app_file("Event().wait()"), seeds=1)
    (record,) = _execute(sweep, LocalEngine(1, wall_timeout_s=3.0)).values()
    check_text(record.result.reason)
    assert (record.path, record.is_failure) == (None, True)
    assert record.result.wall_time_s >= 3.0


@pytest.mark.slow
@pytest.mark.parametrize("judge, verified", [("green-search", False), (None, None)])
def test_a_run_that_died_is_not_verified_if_there_is_a_judge(
    app_file: AppFile, judge: str | None, *, verified: bool | None
) -> None:
    sweep = Sweep(RunRequest(app_file("os._exit(1)"), timeout_s=5.0, judge=judge), worlds=("open",), seeds=(1,))
    (record,) = _execute(sweep, LocalEngine(1)).values()
    result = record.result
    assert (result.outcome, result.verified, result.judge) == (Outcome.ERROR, verified, judge)
    assert record.result.wall_time_s > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("end, outcome", [("pass", "success"), ("os._exit(3)", "error"), ("Event().wait()", "error")])
def test_a_process_in_its_own_session_ends_with_the_sweep(
    app_file: AppFile, tmp_path: Path, end: str, outcome: str
) -> None:
    id_file = tmp_path / "id"
    sweep = make_sweep(app_file(f"open({str(id_file)!r}, 'w').write(str({OWN_SESSION}.pid)); {end}"), seeds=1)
    (record,) = _execute(sweep, LocalEngine(1, wall_timeout_s=3.0)).values()
    assert record.result.outcome.value == outcome
    with pytest.raises(ProcessLookupError):
        os.kill(int(id_file.read_text()), 0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "code",
    [
        f"[os.write(fd, b'\\xff' * 64 + b'\\n') for fd in {PIPES}]",
        f"[os.write(fd, b'\\x00\\x00\\x00\\x10') for fd in {PIPES}]",
        f"[os.write(fd, b'[' * 100_000 + b'\\n') for fd in {PIPES}]",
        f'[os.write(fd, b\'{{"result": 5, "error": null}}\\n\') for fd in {PIPES}]',
        f"[os.close(fd) for fd in {PIPES}]",
    ],
)
def test_a_run_that_writes_to_the_pipe_of_its_worker_fails_alone(app_file: AppFile, tmp_path: Path, code: str) -> None:
    once = f"(not os.path.exists({str(tmp_path / 'once')!r})) and (open({str(tmp_path / 'once')!r}, 'x'), {code})"
    sweep = make_sweep(app_file(once), seeds=3)
    results = [record.result for record in _execute(sweep, LocalEngine(1)).values()]
    assert sorted(result.outcome.value for result in results) == ["error", "success", "success"]


FORGED_ERROR = {"result": None, "error": {"robotcore.errors": ["BackendError", ["forged"], {"exit_status": 0}]}}


@pytest.mark.slow
def test_an_error_that_an_app_forges_fails_its_run_alone(app_file: AppFile) -> None:
    sweep = make_sweep(app_file(_make_forging_code(FORGED_ERROR)), seeds=3)
    records = _execute(sweep, LocalEngine(1))
    assert [records[seed].result.outcome for seed in (1, 2, 3)] == [Outcome.ERROR] * 3
    assert all(record.result.exit_status for record in records.values())


@pytest.mark.slow
@pytest.mark.parametrize(
    "key, value", [("seed", 2), ("app", "x.py"), ("backend", "mock"), ("robot", "lookout"), ("world", "arena")]
)
def test_a_record_of_another_run_that_an_app_forges_fails_its_run_alone(
    app_file: AppFile, key: str, value: str | int
) -> None:
    app = app_file()
    line = _make_forged_line(app, **{key: value})
    app_file(_make_forging_code({"result": [line, ""], "error": None}))
    (record,) = _execute(make_sweep(app, seeds=1), LocalEngine(1)).values()
    assert (record.result.outcome, getattr(record.result, key) == value) == (Outcome.ERROR, False)


@pytest.mark.slow
def test_an_app_cannot_forge_the_command_and_the_path_of_the_picture(app_file: AppFile) -> None:
    app = app_file()
    line = _make_forged_line(app)
    app_file(_make_forging_code({"result": [line, ""], "error": None}))
    sweep = make_sweep(app, seeds=1)
    (record,) = _execute(sweep, LocalEngine(1)).values()
    assert (record.command, record.picture) == (format_command(next(sweep.requests())), None)


def _make_forged_line(app: str, /, **changed: Any) -> str:
    result = RunResult(app, "kinematic", "rover", "open", 1, Outcome.SUCCESS, exit_status=0, verified=True)
    return Record(replace(result, **changed), None, "rm -rf ~", "../../picture.png").to_json()


def _make_forging_code(answer: dict[str, Any]) -> str:
    line = json.dumps(answer).encode() + b"\n"
    return f"[os.write(fd, {line!r}) for fd in {PIPES}] and Event().wait()"


@pytest.mark.slow
def test_a_run_that_died_has_its_conditions(app_file: AppFile) -> None:
    request = RunRequest(app_file("os._exit(1)"), timeout_s=5.0, randomise=True)
    sweep = Sweep(request, worlds=("open",), seeds=(1,))
    (record,) = _execute(sweep, LocalEngine(1)).values()
    assert record.result.outcome is Outcome.ERROR
    assert record.result.conditions == Plan.of(next(sweep.requests())).drawn != {}


@pytest.mark.slow
def test_a_run_in_a_world_that_cannot_be_drawn_has_no_conditions(app_file: AppFile, tmp_path: Path) -> None:
    world = tmp_path / "tight.toml"
    world.write_text('name = "tight"\n[floor]\nlength_m = 0.3\nwidth_m = 0.3\n')
    (record,) = _execute(make_sweep(app_file(), seeds=1, worlds=(str(world),)), LocalEngine(1)).values()
    assert (record.result.outcome, record.result.conditions) == (Outcome.ERROR, {})


INTERRUPT_AT_START_OF_WORKER = """
import os, signal, sys
if "robotcore.sweep.worker" in sys.orig_argv[-1]:
    os.killpg(os.getpgid(os.getppid()), signal.SIGINT)
"""


@pytest.mark.slow
def test_ctrl_c_while_workers_start_is_reported_once(app_file: AppFile, tmp_path: Path) -> None:
    """A terminal sends SIGINT to the whole process group. No worker is in the group."""
    (tmp_path / "sitecustomize.py").write_text(INTERRUPT_AT_START_OF_WORKER)
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


@pytest.mark.slow
def test_a_worker_blocks_no_signals_after_its_start(app_file: AppFile) -> None:
    code = "assert not signal.pthread_sigmask(signal.SIG_BLOCK, ())"
    assert _execute(make_sweep(app_file(code), seeds=1), LocalEngine(1))[1].result.outcome is Outcome.SUCCESS


def test_closing_the_generator_ends_the_running_run(app_file: AppFile, tmp_path: Path) -> None:
    """A fixture checks after each test that no process still runs."""
    first = tmp_path / "first"
    sweep = make_sweep(
        app_file(f"os.path.exists({str(first)!r}) and Event().wait(); open({str(first)!r}, 'w')"), seeds=9
    )
    with closing(LocalEngine(1, wall_timeout_s=1e6).perform(sweep, sweep.requests())) as outputs:
        next(outputs)


def test_workers_compute_with_one_thread_each(app_file: AppFile) -> None:
    code = "assert (cv2.getNumThreads(), os.environ['OPENBLAS_NUM_THREADS']) == (1, '1')"
    sweep = make_sweep(app_file(code, head="import cv2"), seeds=1)
    assert _execute(sweep, LocalEngine(1))[1].result.outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_a_worker_ends_if_its_parent_is_killed(app_file: AppFile, tmp_path: Path) -> None:
    id_file = tmp_path / "worker"
    app = app_file(f"open({str(id_file)!r}, 'w').write(str(os.getpid())); os.kill({SWEEP_ID}, 9); Event().wait()")
    done = subprocess.run([sys.executable, "-m", "robotcore", *_sweep(app, tmp_path)], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL
    _require_gone(int(id_file.read_text()))


@pytest.mark.slow
@pytest.mark.parametrize("code", ["os.system('echo verified')", "(print('verified'), os._exit(0))"])
def test_the_output_of_an_app_goes_to_standard_error_even_if_the_app_exits(
    app_file: AppFile, tmp_path: Path, code: str
) -> None:
    command = [sys.executable, "-m", "robotcore", *_sweep(app_file(code), tmp_path), "--json"]
    env = {**os.environ, "PYTHONUNBUFFERED": ""}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
    assert len(done.stdout.splitlines()) == 1
    assert "verified\n" in done.stderr


def _sweep(app: str, folder: Path) -> list[str]:
    return ["sweep", app, "--world", "open", "--seeds", "1", "--jobs", "1", "--out", str(folder / "out")]


def _require_gone(process: int) -> None:
    with suppress(ProcessLookupError), open(os.pidfd_open(process)) as ended:  # noqa: PTH123  a process, not a path
        assert select([ended], [], [], 30.0)[0]


@pytest.mark.slow
def test_a_sweep_resumes_with_the_missing_runs(tmp_path: Path, app_file: AppFile) -> None:
    sweep = make_sweep(app_file(), seeds=3)
    first = run_sweep(sweep, _PartialEngine(1), tmp_path / "out")
    assert len(list(first.records())) == 1
    assert (tmp_path / "out" / "results.csv").exists()
    engine = _PartialEngine(9)
    second = run_sweep(sweep, engine, tmp_path / "out")
    assert len(engine.requests) == 2
    assert {record.result.seed for record in second.records()} == {1, 2, 3}


class _PartialEngine:
    """An engine that executes runs in this process, and ends after some of them."""

    def __init__(self, runs: int) -> None:
        self._runs = runs
        self.requests: Sequence[RunRequest] = ()

    def perform(self, sweep: Sweep, requests: Any) -> Any:
        from robotcore.sweep.single_run import perform

        self.requests = list(requests)
        yield from map(perform, self.requests[: self._runs])
