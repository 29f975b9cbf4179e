"""Fixtures of every test: no test may leave a thread or a child process."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import coverage
import pytest
from hypothesis import settings

from robotcore.system import HAS_POSIX, IS_LINUX
from tests.texts import check_text as check_text  # noqa: PLC0414  a fixture
from tests.texts import pytest_addoption as pytest_addoption  # noqa: PLC0414  a hook
from tests.texts import raises as raises  # noqa: PLC0414  a fixture

settings.register_profile("no-deadline", deadline=None)  # an example takes longer on a busy machine
settings.load_profile("no-deadline")

GRACE_S = 2.0
"""Seconds for the end of a thread or a child process after the test."""

KEPT = "Dask-"
"""Dask keeps threads whose names begin so, from their first use to the end of the process."""


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip a test that needs POSIX or Linux on a system without it, also if `tests.no_posix` hides it."""
    for name, is_there in (("posix", HAS_POSIX), ("linux", IS_LINUX)):
        for marker in item.iter_markers(name):
            if not is_there:
                pytest.skip(f"needs {name}: {marker.args[0]}")


@pytest.fixture(autouse=True)
def _nothing_is_left_running() -> Iterator[None]:
    threads, children = set(threading.enumerate()), _children()
    yield
    left = [each for each in threading.enumerate() if each not in threads and not each.name.startswith(KEPT)]
    for thread in left:
        thread.join(GRACE_S)
    if alive := [thread.name for thread in left if thread.is_alive()]:
        pytest.fail(f"the test left threads running: {', '.join(alive)}; close what started them")
    end = time.monotonic() + GRACE_S
    while (born := _children() - children) and time.monotonic() < end:
        time.sleep(0.05)
    if born:
        names = ", ".join(f"{child} ({_read(Path(f'/proc/{child}/stat'))[:40]})" for child in sorted(born))
        pytest.fail(f"the test left child processes: {names}; end them and wait for them")


def _children() -> set[int]:
    """Return the process ids of this process's children, or none on a system without ``/proc``."""
    files = Path(f"/proc/{os.getpid()}/task").glob("*/children")
    return {int(child) for file in files for child in _read(file).split()}


def _read(file: Path) -> str:
    """Return the text of a file of ``/proc``, or nothing if its thread has ended."""
    with suppress(FileNotFoundError, ProcessLookupError):
        return file.read_text()
    return ""


@pytest.fixture(scope="session", autouse=True)
def no_lock_of_coverage() -> None:
    """Remove the lock of coverage, which an interrupted run would never release."""
    if (measuring := coverage.Coverage.current()) and (collector := measuring._collector):
        collector.data_lock = None
