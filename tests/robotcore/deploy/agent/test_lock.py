from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.lock import hold_lock
from tests.texts import Raises

HOLD = """
import subprocess, sys
from pathlib import Path
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.lock import hold_lock
with hold_lock(Layout(Path(sys.argv[1])), "installation of another release") as handle:
    print("held", flush=True)
    sys.stdin.read()
"""


@contextmanager
def other_process(layout: Layout) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-c", HOLD, str(layout.home)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_busy_error_names_the_holder(layout: Layout) -> None:
    with other_process(layout) as process, pytest.raises(AgentError) as refused, hold_lock(layout, "push", 0.2):
        pytest.fail("two at a time")
    assert refused.value.kind == "busy"
    assert refused.value.fields["holder"] == f"installation of another release, process {process.pid}"


def test_child_with_the_handle_holds_the_lock_after_its_parent_has_ended(layout: Layout, raises: Raises) -> None:
    with hold_lock(layout, "installation") as handle:
        child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, pass_fds=(handle,))
    with child, raises(AgentError, "busy", hide=[os.getpid()]), hold_lock(layout, "push", 0.2):
        pytest.fail("the child's work is not over")
    with hold_lock(layout, "push", 0.2):
        pass


def test_process_that_waited_for_a_removed_lock_file_locks_the_new_one(
    layout: Layout, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock_file = fcntl.flock

    def remove_and_lock(handle: int, operation: int) -> None:
        monkeypatch.undo()
        layout.lock.unlink()
        lock_file(handle, operation)

    monkeypatch.setattr(fcntl, "flock", remove_and_lock)
    with hold_lock(layout, "push", 10) as handle:
        assert os.fstat(handle).st_ino == layout.lock.stat().st_ino
