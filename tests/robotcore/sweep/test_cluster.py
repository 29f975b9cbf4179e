from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from threading import Thread

import pytest

from robotcore import Outcome
from robotcore.errors import BackendError, BackendMissingError
from robotcore.sweep import ClusterEngine, LocalEngine, Record, Sweep
from robotcore.sweep.engine import Engine
from robotcore.sweep.spec import format_command
from tests.robotcore.sweep.conftest import SWEEP, AppFile, sweep_of

distributed = pytest.importorskip("distributed")


def _dask(*arguments: str, home: Path) -> subprocess.Popen[str]:
    """Start a process of Dask's that tells what it does on stderr; it is a group of its own, with its children."""
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        cwd=home,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )


@contextmanager
def _ended(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def _awaited(process: subprocess.Popen[str], words: str) -> str:
    """Return the line that says so."""
    assert process.stderr
    return next(line for line in process.stderr if words in line)


def _scheduling(home: Path) -> AbstractContextManager[subprocess.Popen[str]]:
    arguments = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show")
    return _ended(_dask("scheduler", *arguments, home=home))


@contextmanager
def _working(scheduler: str, home: Path) -> Iterator[list[subprocess.Popen[str]]]:
    """Two workers, each below a nanny that starts another one where it dies."""
    arguments = (scheduler, "--nthreads", "1", "--no-dashboard", "--local-directory", str(home))
    with ExitStack() as stack:
        processes = [stack.enter_context(_ended(_dask("worker", *arguments, home=home))) for _ in range(2)]
        for process in processes:
            _awaited(process, "Registered to:")
        yield processes


def _address(scheduler_process: subprocess.Popen[str]) -> str:
    return _awaited(scheduler_process, "Scheduler at:").split()[-1]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a cluster for all who leave it as it was."""
    home = tmp_path_factory.mktemp("lab")
    with _scheduling(home) as process, _working(address := _address(process), home):
        yield address


@pytest.fixture
def scheduler_process(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    with _scheduling(tmp_path) as process:
        yield process


@pytest.fixture
def scheduler(scheduler_process: subprocess.Popen[str]) -> str:
    return _address(scheduler_process)


@pytest.fixture
def workers(scheduler: str, tmp_path: Path) -> Iterator[list[subprocess.Popen[str]]]:
    with _working(scheduler, tmp_path) as processes:
        yield processes


def _run(engine: Engine, sweep: Sweep) -> dict[str, Record]:
    """Return the records by their commands, without what no two runs have in common."""
    records = (ended.record for ended in engine.perform(sweep, sweep.requests()))
    return {record.command: replace(record, result=replace(record.result, wall_time_s=0.0)) for record in records}


@pytest.mark.usefixtures("workers")
def test_a_worker_that_is_killed_loses_no_run(scheduler: str, app_file: AppFile, tmp_path: Path) -> None:
    once = str(tmp_path / "once")
    deed = f"os.path.exists({once!r}) or (open({once!r}, 'w'), os.kill({SWEEP}, signal.SIGKILL), Event().wait(1))"
    sweep = sweep_of(app_file(deed), seeds=6)
    swept = _run(ClusterEngine(scheduler), sweep)
    assert Path(once).exists()
    assert {record.result.outcome for record in swept.values()} == {Outcome.SUCCESS}
    assert swept == _run(LocalEngine(1), sweep)


@pytest.mark.parametrize(
    "deed, reason",
    [
        ("Event().wait()", "hung: no end after 4 s of wall time"),
        ("os._exit(0)", "the worker process died: exit status 0"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", "the worker process died: SIGSEGV"),
    ],
)
def test_a_run_that_hangs_or_dies_is_tried_once_and_reported_as_it_is_on_one_machine(
    lab: str, app_file: AppFile, tmp_path: Path, deed: str, reason: str
) -> None:
    tries = tmp_path / "tries"
    sweep = sweep_of(app_file(f"open({str(tries)!r}, 'a').write('I'), {deed}"), seeds=1)
    (record,) = _run(ClusterEngine(lab, wall_timeout_s=4.0), sweep).values()
    assert (record.result.outcome, record.result.reason) == (Outcome.ERROR, reason)
    assert (record.result.app, record.result.world, tries.read_text()) == (sweep.request.app, "open", "I")


def test_a_judge_goes_along_with_what_is_beside_it(
    lab: str, app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    app = Path(app_file("self.reason = helper.WORDS", head="import helper"))
    app.with_name("helper.py").write_text("WORDS = 'app'\n")
    judge = tmp_path / "judge" / app.name
    judge.parent.mkdir()
    judge.with_name("helper.py").write_text("WORDS = 'judge'\n")
    judge.write_text(app.read_text() + "\n    def verify(self, truth):\n        return helper.WORDS == 'judge'\n")
    monkeypatch.chdir(app.parent)
    sweep = sweep_of(app.name)
    judged = replace(sweep, request=replace(sweep.request, judge=f"../judge/{judge.name}"))
    results = [record.result for record in _run(ClusterEngine(lab), judged).values()]
    assert [(result.reason, result.verified) for result in results] == [("app", True)] * 2


def test_what_is_wrong_with_a_file_is_named_by_the_name_it_was_asked_for(
    lab: str, app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    app = Path(app_file())
    judge = tmp_path / "judge.py"
    judge.write_text(app.read_text() + "\n    def verify(self, truth):\n        1 / 0\n")
    monkeypatch.chdir(tmp_path)
    sweep = sweep_of("app/odd.py:Odd", seeds=1)
    judged = replace(sweep, request=replace(sweep.request, judge="judge.py:Odd"))
    for head, each in (("1 / 0", sweep), ("", judged)):
        app_file(head=head)
        assert _run(ClusterEngine(lab), each) == _run(LocalEngine(1), each)


def test_own_files_go_along_anew_when_they_have_changed(
    lab: str, app_file: AppFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    app = Path(app_file("self.reason = helper.WORDS", head="import helper"))
    world = app.with_name("mine.toml")
    world.write_text('name = "mine"\n[floor]\nlength_m = 6.0\nwidth_m = 6.0\n')
    monkeypatch.chdir(app.parent)
    sweep = sweep_of(app.name, worlds=(world.name,))
    for words in ("one", "another", "one"):
        app.with_name("helper.py").write_text(f"WORDS = {words!r}\n")
        records = _run(ClusterEngine(lab), sweep)
        assert {record.result.reason for record in records.values()} == {words}
        assert {(record.result.app, record.result.world) for record in records.values()} == {("odd.py", "mine")}
        assert set(records) == {format_command(request) for request in sweep.requests()}


def test_an_app_that_raises_costs_its_run_alone(lab: str, app_file: AppFile) -> None:
    sweep = sweep_of(app_file("1 / 0"), seeds=1)
    (record,) = _run(ClusterEngine(lab), sweep).values()
    assert record.result.reason == "Odd raised ZeroDivisionError: division by zero"


def test_a_file_that_a_run_misses_costs_that_run_alone(lab: str, app_file: AppFile) -> None:
    app = Path(app_file())
    app.write_text(app.read_text() + "\n    stopping = property(lambda self: open('/no/such/file'))\n")
    records = _run(ClusterEngine(lab), sweep_of(str(app))).values()
    missed = "FileNotFoundError: [Errno 2] No such file or directory: '/no/such/file'"
    assert [record.result.reason for record in records] == [missed] * 2


def test_workers_with_another_library_are_reported_how_to_get_ours(lab: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.runtime.versions.version", lambda name: "1.2.3")
    refused = (
        r"the worker tcp://.* cannot run this: numpy: it has .*, here is 1\.2\.3\. pip install numpy==1\.2\.3 there"
    )
    with pytest.raises(BackendError, match=refused):
        _run(ClusterEngine(lab), sweep_of("green-search"))


def test_workers_with_other_code_are_refused(lab: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.sweep.fingerprint._package_digest", lambda name: "changed")
    with pytest.raises(BackendError, match=r"the worker tcp://.* cannot run this: its robotcore, .* start it again"):
        _run(ClusterEngine(lab), sweep_of("green-search"))


def test_a_worker_that_joins_later_with_other_code_ends_the_sweep_by_its_address(
    lab: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.sweep.fingerprint._package_digest", lambda name: "changed")
    monkeypatch.setattr(ClusterEngine, "_require_workers", lambda *_: None)
    with pytest.raises(BackendError, match=r"the worker tcp://.*start it again. What is done is kept"):
        _run(ClusterEngine(lab), sweep_of("green-search"))


def test_a_cluster_without_workers_is_refused(scheduler: str) -> None:
    with pytest.raises(BackendError, match=f"has no workers. Start some: dask worker {scheduler}"):
        _run(ClusterEngine(scheduler), sweep_of("green-search"))


def test_a_cluster_whose_workers_are_gone_with_their_results_is_given_up(
    scheduler: str, workers: list[subprocess.Popen[str]], app_file: AppFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.sweep.cluster.NO_WORKERS_S", 2.0)
    monkeypatch.setattr("robotcore.sweep.cluster.ANSWER_S", 3.0)
    ended = ClusterEngine(scheduler).perform(sweep := sweep_of(app_file(), seeds=50), sweep.requests())
    assert next(ended).record.result.outcome is Outcome.SUCCESS
    _await_idle(scheduler)
    for worker in workers:
        os.killpg(worker.pid, signal.SIGKILL)
    gone = f"the cluster at {scheduler} has had no workers for 2 s. What is done is kept; start some (dask worker"
    with pytest.raises(BackendError, match=f"^{re.escape(gone)}"):
        list(ended)


def _await_idle(scheduler: str) -> None:
    """Wait until all that was handed out is done; nobody has fetched it yet."""
    with distributed.Client(scheduler, set_as_default=False) as client:
        while any(client.processing().values()):
            pass


@pytest.mark.usefixtures("workers")
def test_a_scheduler_that_is_gone_is_reported(
    scheduler_process: subprocess.Popen[str], scheduler: str, app_file: AppFile
) -> None:
    ended = ClusterEngine(scheduler).perform(sweep := sweep_of(app_file(), seeds=50), sweep.requests())
    assert next(ended).record.result.outcome is Outcome.SUCCESS
    os.killpg(scheduler_process.pid, signal.SIGKILL)
    gone = f"the scheduler at {scheduler} is gone. What is done is kept; the same command goes on"
    with pytest.raises(BackendError, match=f"^{re.escape(gone)}$"):
        list(ended)


def test_no_scheduler_is_reported_with_what_starts_one() -> None:
    with socket.create_server(("127.0.0.1", 0)) as door:
        address = f"tcp://127.0.0.1:{door.getsockname()[1]}"
    for nobody in (address, "nowhere", "carrier://pigeon:1"):
        with pytest.raises(BackendError, match=f"no Dask scheduler answers at '{nobody}'. Start one"):
            _run(ClusterEngine(nobody), sweep_of("green-search"))


@pytest.mark.parametrize("answer", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n", b"\xff" * 4096])
def test_an_address_without_a_scheduler_fails_within_seconds(tmp_path: Path, answer: bytes) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = Thread(target=_answer_all, args=(server, answer), daemon=True)
        thread.start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        words = ["sweep", "green-search", "--cluster", address, "--out", str(tmp_path / "out")]
        done = subprocess.run(
            [sys.executable, "-m", "robotcore", *words], capture_output=True, text=True, check=False, timeout=60.0
        )
        server.shutdown(socket.SHUT_RDWR)
        thread.join()
    assert (done.returncode, done.stderr.count("\n")) == (3, 1)
    assert f"no Dask scheduler answers at '{address}'" in done.stderr


def _answer_all(server: socket.socket, answer: bytes) -> None:
    with ExitStack() as connections, suppress(OSError):
        while True:
            connection, _ = server.accept()
            connections.enter_context(connection).sendall(answer)


def test_a_missing_library_is_reported_with_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BackendMissingError, match=r"pip install 'robotcore\[cluster\]'"):
        _run(ClusterEngine("tcp://127.0.0.1:1"), sweep_of("green-search"))
