"""Worker processes: calls, replies, and the ends of processes."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from threading import Event, Lock, Thread, Timer

import pytest

from robotcore.errors import DeployError, RobotcoreError, UnknownNameError
from robotcore.sweep.worker import NoWorkerError, WorkerEndedError, WorkerProcess
from robotcore.sweep.worker_loop import read_reply
from tests.texts import CheckText, Raises


@pytest.fixture
def child() -> Iterator[WorkerProcess]:
    with closing(WorkerProcess()) as child:
        yield child


@pytest.mark.slow
def test_an_error_of_robotcore_comes_back_unchanged(child: WorkerProcess) -> None:
    error = UnknownNameError("app", "x", ["y"])
    with pytest.raises(UnknownNameError) as raised:
        child.call(raise_, error, limit_s=30)
    assert (str(raised.value), vars(raised.value)) == (str(error), vars(error))


@pytest.mark.slow
@pytest.mark.parametrize("function, arguments", [(int, ("x",)), (Lock, ())], ids=["exception", "no JSON"])
def test_another_exception_comes_back_as_text_and_the_process_continues(
    child: WorkerProcess, function: Callable[..., object], arguments: tuple[object, ...], raises: Raises
) -> None:
    before = child.call(os.getpid, limit_s=30)
    with raises(RobotcoreError):
        child.call(function, *arguments, limit_s=30)
    assert child.call(os.getpid, limit_s=30) == before != os.getpid()


@pytest.mark.slow
@pytest.mark.linux("it lists the open sockets")
def test_a_forked_process_has_no_link_to_write_a_reply_to(child: WorkerProcess) -> None:
    assert child.call(reply_in_fork, limit_s=30) == 0


@pytest.mark.slow
@pytest.mark.linux("it counts file descriptors")
def test_a_worker_starts_with_more_open_files_than_select_allows(child: WorkerProcess) -> None:
    with ExitStack() as opened:
        for _ in range(1100):
            opened.enter_context(Path(os.devnull).open())
        assert child.call(math.hypot, 3, 4, limit_s=30) == 5


@pytest.mark.slow
@pytest.mark.parametrize(
    "reply",
    [b"[1]\n", b"\x80\x04N.\n", b'{"result": 1, "error": {"robotcore.errors": 1}}\n', b"x" * 300_000],
    ids=["list", "pickle", "error", "no end"],
)
def test_after_a_garbled_reply_the_next_call_has_another_process(
    child: WorkerProcess, reply: bytes, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("robotcore.sweep.worker.MAX_REPLY_BYTES", 200_000)
    with pytest.raises(WorkerEndedError) as raised:
        child.call(send, reply, limit_s=30)
    check_text(raised.value)
    assert child.call(math.hypot, 3, 4, limit_s=30) == 5


@pytest.mark.parametrize("name", ["BehaviourError.__init__", "Sequence", "Interrupted"])
def test_a_reply_makes_no_object_but_an_error_of_robotcore(name: str, check_text: CheckText) -> None:
    line = json.dumps({"result": None, "error": {"robotcore.errors": [name, [], {}]}})
    with pytest.raises(ValueError) as raised:  # noqa: PT011  the text is checked
        read_reply(line.encode())
    check_text(raised.value)


@pytest.mark.slow
def test_a_reply_cannot_replace_the_exit_status_of_an_error(child: WorkerProcess) -> None:
    state = {"exit_status": 0, "__str__": "", "kind": "forged"}
    line = json.dumps({"result": None, "error": {"robotcore.errors": ["DeployError", ["forged"], state]}})
    with pytest.raises(DeployError) as raised:
        child.call(send, line.encode() + b"\n", limit_s=30)
    assert (raised.value.exit_status, vars(raised.value)) == (DeployError.exit_status, {"kind": "forged"})


@pytest.mark.slow
def test_a_process_that_sends_half_a_reply_and_hangs_is_ended(child: WorkerProcess) -> None:
    with pytest.raises(WorkerEndedError):
        child.call(send, b'{"result": ', limit_s=2.0)


@pytest.mark.slow
def test_a_process_that_ended_between_two_calls_fails_no_call(child: WorkerProcess) -> None:
    child.call(end_soon, limit_s=30)
    assert child._process
    child._process._popen.wait()
    assert child.call(math.hypot, 3, 4, limit_s=1e300) == 5  # a limit may be longer than a system can wait


def test_a_process_that_cannot_be_started_is_reported(
    child: WorkerProcess, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    with raises(NoWorkerError, "worker-not-started"):
        child.call(os.getpid, limit_s=30)


@pytest.mark.slow
def test_a_killed_worker_ends_its_call_and_takes_no_other(child: WorkerProcess) -> None:
    child.call(os.getpid, limit_s=30)
    errors: list[Exception] = []

    def call() -> None:
        try:
            child.call(wait_for_ever, limit_s=60)
        except WorkerEndedError as error:
            errors.append(error)

    thread = Thread(target=call)
    thread.start()
    child.kill()
    thread.join()
    assert isinstance(errors[0], WorkerEndedError)
    with pytest.raises(WorkerEndedError):
        child.call(os.getpid, limit_s=30)


def test_a_process_that_ends_while_it_starts_is_reported(
    child: WorkerProcess, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(sys, "path", [])
    with raises(NoWorkerError, "worker-not-started"):
        child.call(os.getpid, limit_s=30)


@pytest.mark.slow
def test_a_process_that_hangs_while_it_starts_is_reported(
    child: WorkerProcess, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises
) -> None:
    (tmp_path / "cv2.py").write_text("import threading; threading.Event().wait()")
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.setattr("robotcore.sweep.worker._START_S", 3.0)
    with raises(NoWorkerError, "worker-not-started"):
        child.call(os.getpid, limit_s=30)


def reply_in_fork() -> int:
    """Fork a process that writes to each socket of this one. Return its exit status, 1 if it could write."""
    if (process := os.fork()) == 0:
        sockets = [int(each.name) for each in Path("/proc/self/fd").iterdir() if each.is_socket()]
        written = [os.write(each, b"1\n") for each in sockets]
        os._exit(bool(written))
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def raise_(error: Exception) -> None:
    raise error


def send(reply: bytes) -> None:
    (pipe,) = (int(fd.name) for fd in Path("/proc/self/fd").iterdir() if fd.is_socket())
    os.write(pipe, reply)
    wait_for_ever()


def end_soon() -> None:
    Timer(0.01, os._exit, (0,)).start()


def wait_for_ever() -> None:
    Event().wait()
