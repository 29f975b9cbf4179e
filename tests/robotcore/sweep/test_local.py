from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from select import select
from threading import Event
from unittest.mock import Mock

import pytest

from robotcore import Outcome, RunRequest, RunResult, run
from robotcore.errors import BackendError, RobotcoreError
from robotcore.runtime.plan import Plan
from robotcore.sweep import LocalEngine, Record, Sweep
from robotcore.sweep.single_run import RunOutput, attempt
from robotcore.sweep.spec import format_command
from robotcore.sweep.worker import WorkerProcess
from tests.robotcore.sweep.conftest import SWEEP_ID, AppFile, make_sweep
from tests.texts import CheckText

OWN_SESSION = "__import__('subprocess').Popen(['sleep', '60'], start_new_session=True)"
PIPES = "[int(fd.name) for fd in __import__('pathlib').Path('/proc/self/fd').iterdir() if fd.is_socket()]"
"""The expression in an app for the file descriptors of its worker's pipes, one of which leads to the parent."""


def _execute(sweep: Sweep, engine: LocalEngine) -> dict[int | None, Record]:
    return {record.result.seed: record for record, _ in engine.perform(sweep, sweep.requests())}


def _drop_measured_times(result: RunResult) -> RunResult:
    return replace(result, wall_time_s=0.0, tick_times_us={})


@pytest.mark.slow
def test_a_run_of_a_sweep_has_the_result_of_a_single_run_and_a_point_every_half_second() -> None:
    sweep = Sweep(RunRequest("avoid-obstacles", settings={"duration_s": 8.0}), worlds=("open",), seeds=(1, 2, 3))
    records = _execute(sweep, LocalEngine(2))
    for request in sweep.requests():
        record = records[request.seed]
        assert _drop_measured_times(record.result) == _drop_measured_times(run(request))


@pytest.mark.slow
@pytest.mark.parametrize(
    "code",
    [
        "1 / 0",
        "os.kill(os.getpid(), signal.SIGKILL)",
        f"[os.write(fd, b'\\xff' * 64 + b'\\n') for fd in {PIPES}]",
        f"[os.write(fd, b'\\x00\\x00\\x00\\x10') for fd in {PIPES}]",
        f"[os.write(fd, b'[' * 100_000 + b'\\n') for fd in {PIPES}]",
        f'[os.write(fd, b\'{{"result": 5, "error": null}}\\n\') for fd in {PIPES}]',
        f"[os.close(fd) for fd in {PIPES}]",
    ],
    ids=["raises", "dies", "no Unicode", "half a length", "no end", "another reply", "closes its pipe"],
)
def test_a_run_that_raises_dies_or_writes_to_its_pipe_fails_alone(app_file: AppFile, tmp_path: Path, code: str) -> None:
    once = f"(not os.path.exists({str(tmp_path / 'once')!r})) and (open({str(tmp_path / 'once')!r}, 'x'), {code})"
    sweep = make_sweep(app_file(once), seeds=3)
    results = [record.result for record in _execute(sweep, LocalEngine(1)).values()]
    assert sorted(result.outcome.value for result in results) == ["error", "success", "success"]
    assert {(result.app, result.robot, result.world) for result in results} == {(sweep.request.app, "rover", "open")}


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
@pytest.mark.posix("it sends signals, and forks")
def test_a_worker_that_exits_is_reported_at_once_with_its_status(
    app_file: AppFile, code: str, check_text: CheckText
) -> None:
    (record,) = _execute(make_sweep(app_file(code), seeds=1), LocalEngine(1, wall_timeout_s=1e6)).values()
    check_text(record.result.reason, hide=[signal.SIGRTMIN + 1])


@pytest.mark.slow
@pytest.mark.posix("it forks")
def test_a_process_that_an_app_forks_cannot_reply(app_file: AppFile) -> None:
    sweep = make_sweep(app_file("os.fork() or Event().wait(0.02)"), seeds=20)
    seeds = [output.record.result.seed for output in LocalEngine(1).perform(sweep, sweep.requests())]
    assert seeds == list(sweep.seeds)


@pytest.mark.slow
@pytest.mark.posix("Windows has no sessions")
@pytest.mark.parametrize("end, outcome", [("pass", "success"), ("os._exit(3)", "error"), ("Event().wait()", "error")])
def test_a_process_in_its_own_session_ends_with_the_sweep(
    app_file: AppFile, tmp_path: Path, end: str, outcome: str, check_text: CheckText
) -> None:
    id_file = tmp_path / "id"
    sweep = make_sweep(app_file(f"open({str(id_file)!r}, 'w').write(str({OWN_SESSION}.pid)); {end}"), seeds=1)
    (record,) = _execute(sweep, LocalEngine(1, wall_timeout_s=3.0)).values()
    assert (record.result.outcome.value, record.path is None) == (outcome, outcome == "error")
    check_text(record.result.reason)
    with pytest.raises(ProcessLookupError):
        os.kill(int(id_file.read_text()), 0)


@pytest.mark.parametrize(
    "key, value", [("seed", 2), ("app", "x.py"), ("backend", "mock"), ("robot", "lookout"), ("world", "arena")]
)
def test_a_reply_with_the_record_of_another_run_is_an_error(key: str, value: str | int) -> None:
    output = _attempt([Record(replace(FORGED, **{key: value}), None, "").to_json(), ""])  # type: ignore[arg-type]
    assert (output.record.result.outcome, getattr(output.record.result, key)) == (Outcome.ERROR, getattr(FORGED, key))


def test_a_reply_cannot_change_the_command_and_the_path_of_the_picture() -> None:
    record = _attempt([Record(FORGED, None, "rm -rf ~", "../../picture.png").to_json(), ""]).record
    assert (record.result, record.command, record.picture) == (FORGED, format_command(REQUEST), None)


@pytest.mark.parametrize("judge, verified", [("green-search", False), (None, None)])
def test_a_run_whose_reply_is_an_error_fails_with_its_conditions_and_is_not_verified(
    judge: str | None, *, verified: bool | None
) -> None:
    request = replace(REQUEST, judge=judge, randomise=True)
    result = _attempt(BackendError("forged"), request).record.result
    assert (result.outcome, result.verified, result.judge) == (Outcome.ERROR, verified, judge)
    assert (result.exit_status, result.conditions) == (RobotcoreError.exit_status, Plan.resolve(request).drawn)
    assert result.conditions


REQUEST = RunRequest("green-search", world="open", seed=1)
FORGED = RunResult("green-search", "kinematic", "rover", "open", 1, Outcome.SUCCESS, exit_status=0, verified=True)


def _attempt(reply: list[str] | RobotcoreError, request: RunRequest = REQUEST) -> RunOutput:
    """Attempt a run in a worker process that an app has made reply with something else."""
    with closing(WorkerProcess()) as worker, pytest.MonkeyPatch.context() as patch:
        patch.setattr(worker, "call", Mock(side_effect=[reply]))
        return attempt(worker, request, limit_s=1.0)


INTERRUPT_AT_START_OF_WORKER = """
import os, signal, sys
if "robotcore.sweep.worker" in " ".join(sys.orig_argv):
    os.killpg(os.getpgid(os.getppid()), signal.SIGINT)
"""


@pytest.mark.slow
@pytest.mark.posix("it sends SIGINT to a process group")
def test_ctrl_c_while_workers_start_is_reported_once(app_file: AppFile, tmp_path: Path) -> None:
    """A terminal sends SIGINT to the whole process group. No worker is in the group."""
    (tmp_path / "sitecustomize.py").write_text(INTERRUPT_AT_START_OF_WORKER)
    done = _run_sweep(app_file(), tmp_path, PYTHONPATH=os.pathsep.join([str(tmp_path), *sys.path]))
    assert done.returncode == -signal.SIGINT
    assert "KeyboardInterrupt" not in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_closing_the_generator_ends_the_running_run(app_file: AppFile, tmp_path: Path) -> None:
    """A fixture checks after each test that no process still runs."""
    first = tmp_path / "first"
    sweep = make_sweep(
        app_file(f"os.path.exists({str(first)!r}) and Event().wait(); open({str(first)!r}, 'w')"), seeds=9
    )
    with closing(LocalEngine(1, wall_timeout_s=1e6).perform(sweep, sweep.requests())) as outputs:
        next(outputs)


def test_at_most_two_outputs_a_job_wait_for_a_slow_consumer(monkeypatch: pytest.MonkeyPatch) -> None:
    seeds: list[int | None] = []
    is_third_started = Event()

    def attempt_at_once(_: WorkerProcess, request: RunRequest, __: float) -> RunOutput:
        seeds.append(request.seed)
        if len(seeds) == 3:
            is_third_started.set()
        return RunOutput(Record(replace(FORGED, seed=request.seed), None, ""))

    monkeypatch.setattr("robotcore.sweep.engine.attempt", attempt_at_once)
    sweep = make_sweep("green-search", seeds=9)
    with closing(LocalEngine(1).perform(sweep, sweep.requests())) as outputs:
        next(outputs)
        assert not is_third_started.wait(0.2)
        assert len(list(outputs)) == 8
    with closing(LocalEngine(1).perform(sweep, sweep.requests())) as outputs:
        next(outputs)  # closing ends the thread that waits


@pytest.mark.slow
def test_workers_compute_with_one_thread_and_block_no_signals(app_file: AppFile) -> None:
    threads = "(cv2.getNumThreads(), os.environ['OPENBLAS_NUM_THREADS']) == (1, '1')"
    code = f"assert {threads} and not signal.pthread_sigmask(signal.SIG_BLOCK, ())"
    sweep = make_sweep(app_file(code, head="import cv2"), seeds=1)
    assert _execute(sweep, LocalEngine(1))[1].result.outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_a_worker_ends_if_its_parent_is_killed(app_file: AppFile, tmp_path: Path) -> None:
    id_file = tmp_path / "worker"
    app = app_file(f"open({str(id_file)!r}, 'w').write(str(os.getpid())); os.kill({SWEEP_ID}, 9); Event().wait()")
    assert _run_sweep(app, tmp_path).returncode == -signal.SIGKILL
    worker = int(id_file.read_text())
    with suppress(ProcessLookupError), open(os.pidfd_open(worker)) as ended:  # noqa: PTH123  a process, not a path
        assert select([ended], [], [], 30.0)[0]


@pytest.mark.slow
def test_the_output_of_an_app_goes_to_standard_error_even_if_the_app_exits(app_file: AppFile, tmp_path: Path) -> None:
    done = _run_sweep(app_file("(print('verified'), os._exit(0))"), tmp_path, PYTHONUNBUFFERED="")
    assert done.returncode == 0
    assert len(done.stdout.splitlines()) == 1
    assert "verified\n" in done.stderr


def _run_sweep(app: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "robotcore", "sweep", app, "--world", "open", "--seeds", "1", "--jobs", "1"]
    return subprocess.run(
        [*command, "--out", str(folder / "out"), "--json"],
        env={**os.environ, **environment},
        start_new_session=True,
        capture_output=True,
        text=True,
        check=False,
    )
