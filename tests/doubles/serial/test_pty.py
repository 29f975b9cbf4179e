"""A wait for bytes that the kernel never passes on ends with an error."""

from __future__ import annotations

import os
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.doubles.serial import pty as module
from tests.doubles.serial.pty import FULL, Pty


@pytest.fixture
def pty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Pty]:
    monkeypatch.setattr(module, "WAITING_S", 0.05)
    with Pty(tmp_path) as pty:
        yield pty


def test_bytes_that_the_kernel_does_not_take_are_reported(pty: Pty) -> None:
    termios.tcflow(pty._far, termios.TCOOFF)
    with pytest.raises(AssertionError, match=r"0 bytes waited to be read, the kernel took 0 of 5 more, .* 0 wait"):
        pty.send_all(b"hello")


def test_bytes_that_another_reader_took_are_reported(pty: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_by_another(_pty: Pty, data: bytes) -> int:
        termios.tcflush(_pty._near, termios.TCIFLUSH)
        return os.write(_pty._far, data)

    pty.send_all(b"before")
    monkeypatch.setattr(Pty, "send", read_by_another)
    with pytest.raises(AssertionError, match=r"6 bytes waited to be read, the kernel took 5 of 5 more, .* 5 wait"):
        pty.send_all(b"hello")


def test_more_bytes_than_the_kernel_stores_are_not_waited_for(pty: Pty) -> None:
    for _ in range(20):
        pty.send_all(bytes(FULL))


def test_a_marker_byte_that_the_kernel_does_not_take_is_reported(pty: Pty) -> None:
    termios.tcflow(pty._near, termios.TCOOFF)
    with pytest.raises(AssertionError, match="took 0 bytes of a mark"):
        pty.read_all()


def test_a_missing_marker_byte_is_reported(pty: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Pty, "read", lambda _pty, _wait_s=0.0: b"chatter")
    with pytest.raises(AssertionError, match="reads or sends"):
        pty.read_all()
