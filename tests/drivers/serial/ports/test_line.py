from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from drivers.serial.ports.line import Line
from drivers.serial.ports.talk import Talk
from robotcore.clock import MonotonicClock
from robotcore.errors import DeviceError, DeviceLostError
from tests.doubles.serial.pty import Pty


class Asking(Talk):
    """Asks until it is answered, then says each word that it is told once."""

    baud = 115200

    def __init__(self) -> None:
        self.is_ready = False
        self.word = b""

    def begin(self, now: float) -> None:
        self.is_ready = False
        self.word = b"?"

    def receive(self, data: bytes, now: float) -> None:
        self.is_ready = True

    def due(self, now: float) -> bytes:
        word, self.word = self.word, b""
        return word


class Answering:
    """Answers each question, and keeps all that it hears."""

    def __init__(self, pty: Pty) -> None:
        self.pty, self.heard, self.is_over = pty, b"", False
        self._thread = threading.Thread(target=self._answer)
        self._thread.start()

    def close(self) -> None:
        self.is_over = True
        self._thread.join()

    def _answer(self) -> None:
        clock = MonotonicClock()
        while not self.is_over:
            clock.sleep_until(clock.now() + 0.001)
            heard = self.pty.heard()
            self.heard += heard
            if b"?" in heard:
                self.pty.say(b"!")


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Answering]:
    with Pty(tmp_path) as pty:
        answering = Answering(pty)
        yield answering
        answering.close()


def test_what_is_due_is_sent_and_what_comes_is_received(board: Answering) -> None:
    clock, talk = MonotonicClock(), Asking()
    line = Line(str(board.pty.path), talk, clock)
    line.open("wheel", 1.0)
    line.require("wheel")
    talk.word = b"go"
    line.close()
    clock.sleep_until(clock.now() + 0.05)
    assert board.heard == b"?go"


def test_a_lost_port_is_an_error_by_name_and_comes_back(board: Answering) -> None:
    clock, talk = MonotonicClock(), Asking()
    line = Line(str(board.pty.path), talk, clock)
    line.open("wheel", 1.0)
    board.pty.unplug()
    with pytest.raises(DeviceLostError, match=r"wheel: .*board is gone"):
        _require_often(line, clock)
    board.pty.plug_in()
    for _ in range(5000):
        if board.heard == b"??" and talk.is_ready:
            break
        clock.sleep_until(clock.now() + 0.001)
    line.require("wheel")
    line.close()


def test_a_port_on_which_nobody_answers_is_refused(tmp_path: Path) -> None:
    with Pty(tmp_path) as pty, pytest.raises(DeviceError, match=r"wheel: nothing on .*board answers at 115200 baud"):
        Line(str(pty.path), Asking(), MonotonicClock()).open("wheel", 0.05)


def _require_often(line: Line, clock: MonotonicClock) -> None:
    for _ in range(5000):
        line.require("wheel")
        clock.sleep_until(clock.now() + 0.001)
