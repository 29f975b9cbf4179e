from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from drivers.raspberrypi.owner import Owner

HALF_GONE = """
import ctypes, threading, time
threading.Thread(target=time.sleep, args=(600,)).start()
input()
ctypes.CDLL(None).pthread_exit(None)
"""


@pytest.fixture
def process() -> Iterator[subprocess.Popen[str]]:
    """A process that waits, and whose main thread then ends before another one."""
    with subprocess.Popen([sys.executable, "-c", HALF_GONE], stdin=subprocess.PIPE, text=True) as running:
        yield running
        running.kill()


def test_one_that_waits_has_not_begun_to_end(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    assert not owner.is_ending()
    assert not owner.has_ended_within(0.0)
    owner.close()


def test_one_that_has_begun_to_end_and_has_threads_at_work_can_still_be_killed(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    assert process.stdin
    process.stdin.write("\n")
    process.stdin.flush()
    while not owner.is_ending():
        pass
    assert not owner.has_ended_within(0.0)
    owner.kill()
    assert owner.has_ended_within(60.0)
    assert process.wait() == -signal.SIGKILL
    owner.close()


def test_one_that_has_gone_is_not_taken_for_whoever_gets_its_number(process: subprocess.Popen[str]) -> None:
    owner = Owner(process.pid)
    process.kill()
    process.wait()
    assert owner.is_ending()
    owner.kill()
    owner.close()


def test_one_that_is_not_there_is_told(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait()
    with pytest.raises(ProcessLookupError):
        Owner(process.pid)
