"""Runs on a Python without threads, such as one in a web page."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from types import SimpleNamespace
from typing import Any

import pytest

from robotcore.errors import ResourceError
from robotcore.runtime.behaviour import Status
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import NO_WATCHDOG, RunRequest, run
from tests.robotcore.fakes import RigBackend
from tests.robotcore.runs import Runner, drive_then, drive_then_raise
from tests.texts import CheckText

WITHOUT_THREADS = """
import json, subprocess, sys, threading
from types import SimpleNamespace

def refuse(*args, **kwargs):
    raise RuntimeError("can't start new thread")

threading.Thread.start = subprocess.Popen.__init__ = refuse
sys._emscripten_info = SimpleNamespace(pthreads=False)

from robotcore.runtime.session import RunRequest, run

result = run(RunRequest("green-search", seed=7))
print(json.dumps([result.outcome.value, result.trace_sha256, result.notes]))
"""


@pytest.fixture
def no_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make this Python one that cannot start threads, as in a web page."""

    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    monkeypatch.setattr(sys, "_emscripten_info", SimpleNamespace(pthreads=False), raising=False)


@pytest.mark.slow
def test_run_without_threads_and_processes_has_the_digest_of_a_run_with_them() -> None:
    command = [sys.executable, "-c", WITHOUT_THREADS]
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found: list[Any] = json.loads(out)
    with_threads = run(RunRequest("green-search", seed=7))
    assert found == ["success", with_threads.trace_sha256, [NO_WATCHDOG]]
    assert NO_WATCHDOG not in with_threads.notes


@pytest.mark.usefixtures("no_threads")
def test_motors_stop_without_threads_after_an_exception_of_the_app(perform: Runner, backend: RigBackend) -> None:
    result = perform(drive_then_raise(ValueError("bug")))
    assert (result.outcome, result.notes[-1]) == (Outcome.ERROR, NO_WATCHDOG)
    assert backend.rig.wheels == (0.0, 0.0)


@pytest.mark.usefixtures("no_threads")
def test_robot_that_is_not_a_simulation_does_not_open_without_threads(
    perform: Runner, backend: RigBackend, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr(RigBackend, "capabilities", frozenset())
    result = perform(drive_then(lambda _: Status.SUCCESS))
    assert isinstance(result.error, ResourceError)
    assert backend.rigs == []
    check_text(result.error)
