"""The reserve of threads and memory."""

from __future__ import annotations

import mmap
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety import thread_reserve as reserves
from robotcore.safety.thread_reserve import Reserve

NO_ROOM_FOR_A_STACK = """
import resource, threading
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.errors import ResourceError
from robotcore.safety.thread_reserve import Reserve
from robotcore.threads import start_thread

clock = MonotonicClock()
resource.setrlimit(resource.RLIMIT_AS, (1, resource.RLIM_INFINITY))
for refused in (lambda: start_thread(print, "one"), clock.prepare_calls, lambda: Reserve(clock).hold(threads=1)):
    try:
        refused()
    except ResourceError as error:
        print(error.exit_status, error.refusal)
"""


@pytest.fixture
def reserve() -> Iterator[Reserve]:
    reserve = Reserve(MonotonicClock())
    yield reserve
    reserve.close()


@pytest.mark.linux("the limit is one of Linux's address space")
def test_refused_thread_or_memory_is_a_resource_error() -> None:
    out = subprocess.run([sys.executable, "-c", NO_ROOM_FOR_A_STACK], check=True, capture_output=True, text=True).stdout
    assert out.splitlines() == [
        "3 the system refuses the thread 'one'",
        "3 the system refuses the thread 'clock'",
        "3 the system refuses 32 MB of memory",
    ]


def test_call_runs_in_an_idle_thread(reserve: Reserve) -> None:
    reserve.hold(threads=1)
    made_in: list[int] = []
    assert reserve.call(lambda: made_in.append(threading.get_ident())).is_done_within(10)
    assert made_in != [threading.get_ident()]


def test_call_runs_in_the_callers_thread_if_none_is_idle(reserve: Reserve) -> None:
    reserve.hold(threads=1)
    release = threading.Event()
    busy = reserve.call(release.wait)
    made_in: list[int] = []
    reserve.call(lambda: made_in.append(threading.get_ident()))
    assert made_in == [threading.get_ident()]
    assert busy.is_under_way
    release.set()
    assert busy.is_done_within(10)


def test_call_that_runs_out_of_memory_is_repeated_with_the_reserved_memory(reserve: Reserve) -> None:
    reserve.hold(threads=0)
    tries: list[bool] = []

    def attempt() -> None:
        tries.append(reserve._memory is not None)
        if len(tries) == 1:
            raise MemoryError

    reserve.retry_on_memory_error(attempt)
    assert tries == [True, False]


def test_close_ends_every_thread_even_a_busy_one(reserve: Reserve) -> None:
    before = set(threading.enumerate())
    reserve.hold(threads=2)
    release = threading.Event()
    reserve.call(release.wait)
    started = set(threading.enumerate()) - before
    reserve.close()
    release.set()
    for thread in started:
        thread.join(10)
    assert not any(thread.is_alive() for thread in started)


@pytest.mark.linux("it reads /proc")
def test_reserved_memory_takes_address_space_only(reserve: Reserve) -> None:
    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE

    before = resident()
    reserve.hold(threads=0)
    assert resident() - before < reserves.MEMORY_BYTES / 8


def test_call_that_raises_system_exit_does_not_end_its_thread(reserve: Reserve) -> None:
    reserve.hold(threads=1)

    def leave() -> None:
        raise SystemExit

    for _ in range(3):
        call = reserve.call(leave)
        assert call.is_done_within(10)
        assert isinstance(call.failure, SystemExit)
        while not reserve._idle:  # the thread has made the call, and is about to wait
            pass
