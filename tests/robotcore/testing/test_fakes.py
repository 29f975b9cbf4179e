from __future__ import annotations

import threading

import pytest

from robotcore.testing import fakes
from robotcore.testing.fakes import Gate


def test_slow_read_from_memory_is_not_held_up() -> None:
    assert not Gate().blocks(lambda: sum(range(10**6)))


def test_read_that_asks_the_hardware_is_held_up() -> None:
    gate = Gate()
    assert gate.blocks(gate.pass_through)
    gate.pass_through()  # the gate is open again


def test_read_that_waits_for_the_pollers_lock_is_held_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fakes, "SETTLE_LIMIT_S", 0.05)
    gate, lock, has_lock = Gate(), threading.Lock(), threading.Event()

    def poll() -> None:
        with lock:
            has_lock.set()
            gate.pass_through()

    def read() -> None:
        poller.start()
        has_lock.wait()
        with lock:
            pass

    poller = threading.Thread(target=poll)
    assert gate.blocks(read)
    poller.join()


def test_exception_of_the_read_is_raised() -> None:
    with pytest.raises(ConnectionResetError):
        Gate().blocks(_fail)


def _fail() -> None:
    raise ConnectionResetError
