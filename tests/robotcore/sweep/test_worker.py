"""Worker processes: calls, replies, deaths."""

from __future__ import annotations

import json
import math
import os
import pickle
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from subprocess import Popen
from threading import Event, Lock, Thread, Timer

import pytest

from robotcore.errors import BackendError, DeployError, RobotcoreError, StaleSampleError, UnknownNameError
from robotcore.sweep.worker import NoWorkerError, WorkerDiedError, WorkerHungError, WorkerProcess, read_reply
from tests.texts import Raises


@pytest.fixture
def child() -> Iterator[WorkerProcess]:
    with closing(WorkerProcess()) as child:
        yield child


def test_a_call_returns_what_it_returns_here_and_the_process_stays(child: WorkerProcess) -> None:
    assert child.call(math.hypot, 3, 4, limit_s=30) == 5
    assert child.call(os.getpid, limit_s=30) == child.call(os.getpid, limit_s=30) != os.getpid()


@pytest.mark.parametrize("error", [UnknownNameError("app", "x", ["y"]), StaleSampleError("nose", 2.0, 1.0)])
def test_an_error_of_ours_comes_back_as_it_is(child: WorkerProcess, error: RobotcoreError) -> None:
    with pytest.raises(type(error)) as raised:
        child.call(raise_, error, limit_s=30)
    assert str(raised.value) == str(error)
    assert vars(raised.value) == vars(error)


def test_an_error_that_an_app_has_made_of_ours_comes_back_as_ours() -> None:
    class TooFastError(UnknownNameError):
        def __init__(self) -> None:
            super().__init__("app", "x", ["y"])
            self.lock = Lock()

    there = pickle.loads(pickle.dumps(TooFastError()))  # noqa: S301  it never left
    assert (type(there), str(there)) == (UnknownNameError, str(TooFastError()))


def test_any_other_exception_comes_back_in_words(child: WorkerProcess) -> None:
    with pytest.raises(RobotcoreError, match=r"^ValueError: "):
        child.call(math.sqrt, -1, limit_s=30)


def test_what_does_not_fit_through_a_pipe_is_reported_and_the_process_stays(child: WorkerProcess) -> None:
    before = child.call(os.getpid, limit_s=30)
    with pytest.raises(RobotcoreError, match="a lock through a pipe"):
        child.call(Lock, limit_s=30)
    assert child.call(os.getpid, limit_s=30) == before


@pytest.mark.parametrize("status", [0, 3])
def test_a_process_that_ends_in_a_call_is_named_by_its_status_and_the_next_call_has_another(
    child: WorkerProcess, status: int
) -> None:
    with pytest.raises(WorkerDiedError, match=f"^exit status {status}$"):
        child.call(os._exit, status, limit_s=30)
    assert child.call(math.hypot, 3, 4, limit_s=30) == 5


def test_a_call_that_hangs_is_ended(child: WorkerProcess) -> None:
    with pytest.raises(WorkerHungError, match=r"no end after 0\.1 s"):
        child.call(wait_for_ever, limit_s=0.1)


def test_a_process_that_sends_half_an_answer_and_hangs_is_ended(child: WorkerProcess) -> None:
    with pytest.raises(WorkerHungError):
        child.call(answer, b'{"result": ', limit_s=2.0)


@pytest.mark.parametrize("answered", [b"[1]\n", b"\x80\x04N.\n", b'{"result": 1, "error": {"robotcore.errors": 1}}\n'])
def test_an_answer_that_cannot_be_read_ends_the_process_and_the_next_call_has_another(
    child: WorkerProcess, answered: bytes
) -> None:
    with pytest.raises(WorkerDiedError, match="its answer cannot be read"):
        child.call(answer, answered, limit_s=30)
    assert child.call(math.hypot, 3, 4, limit_s=30) == 5


def test_an_answer_without_an_end_is_not_read_for_ever(child: WorkerProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.sweep.worker.MAX_REPLY_BYTES", 200_000)
    with pytest.raises(WorkerDiedError, match="its answer cannot be read"):
        child.call(answer, b"x" * 300_000, limit_s=30)


@pytest.mark.parametrize("name", ["BehaviourError.__init__", "Sequence", "Interrupted"])
def test_an_answer_makes_no_object_but_an_error_of_ours(name: str) -> None:
    line = json.dumps({"result": None, "error": {"robotcore.errors": [name, [], {}]}})
    with pytest.raises(ValueError, match="Error: "):
        read_reply(line.encode())


def test_an_answer_changes_nothing_that_the_class_of_its_error_defines(child: WorkerProcess) -> None:
    state = {"exit_status": 0, "__str__": "", "kind": "forged"}
    line = json.dumps({"result": None, "error": {"robotcore.errors": ["DeployError", ["forged"], state]}})
    with pytest.raises(DeployError) as raised:
        child.call(answer, line.encode() + b"\n", limit_s=30)
    assert (raised.value.exit_status, vars(raised.value)) == (DeployError.exit_status, {"kind": "forged"})


def test_an_error_that_the_process_sends_does_not_say_that_there_is_no_process(child: WorkerProcess) -> None:
    with pytest.raises(BackendError) as raised:
        child.call(raise_, NoWorkerError("forged"), limit_s=30)
    assert type(raised.value) is BackendError


def test_a_limit_may_be_longer_than_a_system_can_wait(child: WorkerProcess) -> None:
    assert child.call(math.hypot, 3, 4, limit_s=1e300) == 5


def test_a_process_that_ended_between_two_calls_costs_none_of_them(child: WorkerProcess) -> None:
    child.call(end_soon, limit_s=30)
    assert child._process
    child._process._popen.wait()
    assert child.call(math.hypot, 3, 4, limit_s=30) == 5


def test_a_process_that_cannot_be_had_is_reported(
    child: WorkerProcess, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    with raises(NoWorkerError, "worker-not-started"):
        child.call(os.getpid, limit_s=30)


def test_a_killed_child_gives_up_its_call_and_takes_no_other(child: WorkerProcess) -> None:
    child.call(os.getpid, limit_s=30)
    said: list[Exception] = []
    thread = Thread(target=_catch, args=(child, said))
    thread.start()
    child.kill()
    thread.join()
    assert isinstance(said[0], WorkerDiedError)
    with pytest.raises(WorkerDiedError):
        child.call(os.getpid, limit_s=30)


def test_a_child_reads_nothing_of_what_is_meant_for_its_parent(child: WorkerProcess, tmp_path: Path) -> None:
    (tmp_path / "typed").write_text("hello\n")
    before = os.dup(0)
    try:
        with (tmp_path / "typed").open() as typed:
            os.dup2(typed.fileno(), 0)
        with pytest.raises(RobotcoreError, match="EOFError"):
            child.call(input, limit_s=30)
    finally:
        os.dup2(before, 0)
        os.close(before)


def test_a_python_that_cannot_start_is_reported(
    child: WorkerProcess, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(sys, "path", [])
    with raises(NoWorkerError, "worker-start-died", how="exit status 1"):
        child.call(os.getpid, limit_s=30)


def test_a_python_that_does_not_come_to_its_start_is_reported(
    child: WorkerProcess, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises
) -> None:
    (tmp_path / "cv2.py").write_text("import threading; threading.Event().wait()")
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.setattr("robotcore.sweep.worker._START_S", 3.0)
    with raises(NoWorkerError, "worker-start-timeout", limit_s=3.0):
        child.call(os.getpid, limit_s=30)


def test_what_a_process_started_ends_with_it(child: WorkerProcess, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "lives")
    with pytest.raises(WorkerDiedError, match="exit status 3"):
        child.call(leave_a_reader_of, tmp_path / "lives", limit_s=30)
    with pytest.raises(OSError, match="No such device or address"):
        wait_until_nobody_reads(tmp_path / "lives")


def raise_(error: Exception) -> None:
    raise error


def answer(answered: bytes) -> None:
    (pipe,) = (int(fd.name) for fd in Path("/proc/self/fd").iterdir() if fd.is_socket())
    os.write(pipe, answered)
    wait_for_ever()


def end_soon() -> None:
    Timer(0.01, os._exit, (0,)).start()


def leave_a_reader_of(fifo: Path) -> None:
    Popen(["/bin/sh", "-c", 'exec sleep 60 < "$0"', str(fifo)])
    os.open(fifo, os.O_WRONLY)
    os._exit(3)


def wait_until_nobody_reads(fifo: Path) -> None:
    """Raise OSError once nobody reads; return, after a while, where somebody still does."""
    for _ in range(100):
        os.close(os.open(fifo, os.O_WRONLY | os.O_NONBLOCK))
        Event().wait(0.02)


def wait_for_ever() -> None:
    Event().wait()


def _catch(child: WorkerProcess, said: list[Exception]) -> None:
    try:
        child.call(wait_for_ever, limit_s=60)
    except WorkerDiedError as error:
        said.append(error)
