"""What holds for every test: none leaves a thread or a child process behind."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

GRACE_S = 2.0
"""A thread that was told to end may take this long."""


@pytest.fixture(autouse=True)
def _nothing_is_left_running() -> Iterator[None]:
    threads, children = set(threading.enumerate()), _children()
    yield
    left = [thread for thread in threading.enumerate() if thread not in threads]
    for thread in left:
        thread.join(GRACE_S)
    if alive := [thread.name for thread in left if thread.is_alive()]:
        pytest.fail(f"the test left threads running: {', '.join(alive)}; close what started them")
    if born := _children() - children:
        pytest.fail(f"the test left child processes: {sorted(born)}; end them and wait for them")


def _children() -> set[int]:
    """Return the process ids of this process's children; nothing where the system does not tell."""
    tasks = Path(f"/proc/{os.getpid()}/task")
    return {int(child) for file in tasks.glob("*/children") for child in file.read_text().split()}
