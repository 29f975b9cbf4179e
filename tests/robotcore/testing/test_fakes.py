from __future__ import annotations

import threading

import pytest

from robotcore.testing import fakes
from robotcore.testing.fakes import Gate


class Polled:
    """A sensor whose hardware is polled in a thread, so that reading it does not wait."""

    def __init__(self, gate: Gate) -> None:
        self._gate = gate
        self._is_closed = False
        self._has_first = threading.Event()
        self._newest = 0
        self._poller = threading.Thread(target=self._poll)
        self._poller.start()
        self._has_first.wait()

    def read(self) -> int:
        return self._newest

    def close(self) -> None:
        self._is_closed = True
        self._poller.join()

    def _poll(self) -> None:
        while not self._is_closed:
            self._gate.pass_through()
            self._newest += 1
            self._has_first.set()


def test_read_from_memory_is_not_held_up() -> None:
    gate = Gate()
    sensor = Polled(gate)
    try:
        assert not gate.blocks(sensor.read)
    finally:
        sensor.close()


def test_slow_read_from_memory_is_not_held_up() -> None:
    assert not Gate().blocks(lambda: sum(range(10**6)))


def test_read_that_asks_the_hardware_is_held_up() -> None:
    gate = Gate()
    assert gate.blocks(gate.pass_through)


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


def test_gate_is_open_again_afterwards() -> None:
    gate = Gate()
    gate.blocks(lambda: None)
    gate.pass_through()


def test_exception_of_the_read_is_raised() -> None:
    with pytest.raises(ConnectionResetError):
        Gate().blocks(_fail)


def _fail() -> None:
    raise ConnectionResetError
