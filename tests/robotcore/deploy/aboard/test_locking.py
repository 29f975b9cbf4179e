from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.locking import locked
from robotcore.deploy.aboard.telling import RefusalError

HOLD = """
import subprocess, sys
from pathlib import Path
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.locking import locked
with locked(Layout(Path(sys.argv[1])), "installation of another release") as handle:
    print("held", flush=True)
    sys.stdin.read()
"""


@contextmanager
def another_at_work(layout: Layout) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-c", HOLD, str(layout.home)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_somebody_else_at_work_is_named(layout: Layout) -> None:
    with another_at_work(layout) as process, pytest.raises(RefusalError) as refused, locked(layout, "push", 0.2):
        pytest.fail("two at a time")
    assert refused.value.kind == "busy"
    assert f"installation of another release, process {process.pid}" in str(refused.value)


def test_who_is_killed_lets_go(layout: Layout) -> None:
    with another_at_work(layout) as process:
        process.kill()
        process.wait()
        with locked(layout, "push", 0.2):
            assert layout.lock.read_text() == f"push, process {os.getpid()}"


def test_a_child_that_is_given_the_lock_holds_it_when_its_parent_is_gone(layout: Layout) -> None:
    with locked(layout, "installation") as handle:
        child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, pass_fds=(handle,))
    with child, pytest.raises(RefusalError, match="installation"), locked(layout, "push", 0.2):
        pytest.fail("the child's work is not over")
    with locked(layout, "push", 0.2):
        pass
