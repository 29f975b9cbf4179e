from __future__ import annotations

import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from socketserver import BaseRequestHandler, ThreadingTCPServer
from threading import Thread
from typing import Any
from unittest.mock import Mock

import pytest

from robotcore import Outcome, RunRequest
from robotcore.errors import BackendError, BackendMissingError
from robotcore.sweep import ClusterEngine, LocalEngine, Record, Sweep
from robotcore.sweep.cluster import _Workers
from robotcore.sweep.engine import Engine
from tests.robotcore.sweep.conftest import SWEEP_ID, AppFile, make_sweep
from tests.texts import CheckText, Raises

distributed = pytest.importorskip("distributed")


@contextmanager
def _run_cluster() -> Iterator[Any]:
    """Run a scheduler in this process, and two worker processes, which it restarts when they die."""
    with distributed.LocalCluster(2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:
        yield cluster


@pytest.fixture(scope="module")
def lab() -> Iterator[str]:
    """The address of a cluster that several tests share. No test kills its processes.

    Tests with an own cluster use it too, because the first cluster starts a process that stays: Python's tracker of
    resources.
    """
    with _run_cluster() as cluster:
        yield cluster.scheduler_address


def _run(engine: Engine, sweep: Sweep) -> dict[str, Record]:
    """Execute a sweep. Return its records by command, with a wall time of 0 s."""
    records = (output.record for output in engine.perform(sweep, sweep.requests()))
    return {
        record.command: replace(record, result=replace(record.result, wall_time_s=0.0, tick_times_us={}))
        for record in records
    }


@pytest.mark.slow
@pytest.mark.usefixtures("lab")
def test_a_worker_that_is_killed_loses_no_run(app_file: AppFile, tmp_path: Path) -> None:
    once = str(tmp_path / "once")
    code = f"os.path.exists({once!r}) or (open({once!r}, 'w'), os.kill({SWEEP_ID}, signal.SIGKILL), Event().wait(1))"
    sweep = make_sweep(app_file(code), seeds=6)
    with _run_cluster() as cluster:
        swept = _run(ClusterEngine(cluster.scheduler_address), sweep)
    assert Path(once).exists()
    assert {record.result.outcome for record in swept.values()} == {Outcome.SUCCESS}
    assert swept == _run(LocalEngine(1), sweep)


@pytest.mark.slow
@pytest.mark.parametrize("code", ["Event().wait()", "os._exit(0)"])
def test_a_run_that_hangs_or_dies_is_tried_once(
    lab: str, app_file: AppFile, tmp_path: Path, code: str, check_text: CheckText
) -> None:
    tries = tmp_path / "tries"
    sweep = make_sweep(app_file(f"open({str(tries)!r}, 'a').write('I'), {code}"), seeds=1)
    (record,) = _run(ClusterEngine(lab, wall_timeout_s=4.0), sweep).values()
    assert record.result.outcome is Outcome.ERROR
    check_text(record.result.reason)
    assert (record.result.app, record.result.world, tries.read_text()) == (sweep.request.app, "open", "I")


def test_a_cluster_without_workers_is_refused(raises: Raises) -> None:
    client = Mock(**{"run.return_value": {}})
    with raises(BackendError, "no-workers", address="tcp://lab:8786"):
        ClusterEngine("tcp://lab:8786")._require_workers(client, Mock())


@pytest.mark.slow
@pytest.mark.usefixtures("lab")
def test_a_scheduler_that_is_gone_is_reported(app_file: AppFile, raises: Raises) -> None:
    with _run_cluster() as cluster:
        address = cluster.scheduler_address
        outputs = ClusterEngine(address).perform(sweep := make_sweep(app_file(), seeds=50), sweep.requests())
        assert next(outputs).record.result.outcome is Outcome.SUCCESS
    with raises(BackendError, "scheduler-gone", hide=[address], address=address):
        list(outputs)


def test_an_address_without_a_scheduler_is_refused(raises: Raises) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
    for absent in (address, "nowhere", "carrier://pigeon:1"):
        with raises(BackendError, "no-scheduler", hide=[absent], address=absent):
            _run(ClusterEngine(absent), make_sweep("green-search"))


def test_a_missing_library_is_reported_with_its_extra(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with raises(BackendMissingError, "library-missing", extra="cluster", modules=["distributed"]):
        _run(ClusterEngine("tcp://127.0.0.1:1"), make_sweep("green-search"))


@pytest.mark.slow
def test_files_are_sent_with_the_modules_beside_them_and_keep_their_names_and_changes_are_sent_again(
    lab: str, app_file: AppFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    app = Path(app_file("self.reason = helper.WORDS", head="import helper"))
    app.with_name("helper.py").write_text("WORDS = 'app'\n")
    world = app.with_name("mine.toml")
    world.write_text('name = "mine"\n[floor]\nlength_m = 6.0\nwidth_m = 6.0\n')
    judge = tmp_path / "judge" / app.name
    judge.parent.mkdir()
    judge.write_text(app.read_text() + "\n    def verify(self, truth):\n        raise ValueError(helper.WORDS)\n")
    monkeypatch.chdir(app.parent)
    sweep = make_sweep(app.name, worlds=(world.name,))
    judged = replace(sweep, request=replace(sweep.request, judge=f"../judge/{judge.name}"))
    for words in ("one", "another", "one"):
        judge.with_name("helper.py").write_text(f"WORDS = {words!r}\n")
        records = _run(ClusterEngine(lab), judged)
        assert all(f"ValueError: {words}" in record.result.reason for record in records.values())
    assert records == _run(LocalEngine(1), judged)
    assert {record.result.world for record in records.values()} == {"mine"}


@pytest.mark.slow
@pytest.mark.parametrize("joins_later", [False, True])
def test_workers_with_other_code_are_refused(lab: str, monkeypatch: pytest.MonkeyPatch, *, joins_later: bool) -> None:
    monkeypatch.setattr("robotcore.sweep.fingerprint._compute_package_digest", lambda name: "changed")
    if joins_later:
        monkeypatch.setattr(ClusterEngine, "_require_workers", lambda *_: None)
    with pytest.raises(BackendError, match="the code of robotcore is") as raised:
        _run(ClusterEngine(lab), make_sweep("green-search"))
    assert (raised.value.kind, "The same command" in str(raised.value)) == ("worker-mismatch", joins_later)


@pytest.mark.slow
def test_a_sweep_ends_if_the_workers_are_gone_with_their_results(
    monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    """Dask would wait for ever for another worker that repeats the run."""
    monkeypatch.setattr("robotcore.sweep.cluster.NO_WORKERS_S", 0.0)
    client, lost = Mock(), Mock(status="pending")
    client.nthreads.return_value = {}
    lost.result.side_effect = distributed.TimeoutError
    with raises(BackendError, "workers-gone", address="tcp://lab:8786"):
        _Workers(client, "tcp://lab:8786").await_output(RunRequest("green-search"), lost)


@pytest.mark.slow
def test_an_address_of_another_program_is_refused_within_seconds(raises: Raises) -> None:
    class Refusal(BaseRequestHandler):
        def handle(self) -> None:
            self.request.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")

    with ThreadingTCPServer(("127.0.0.1", 0), Refusal) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.server_address[1]}"
        with raises(BackendError, "no-scheduler", hide=[address], address=address):
            _run(ClusterEngine(address), make_sweep("green-search"))
        server.shutdown()
