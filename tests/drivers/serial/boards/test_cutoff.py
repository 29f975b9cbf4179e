"""A guardian stops the board of a killed or suspended program by a stop frame on a pty."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

from drivers.serial.boards.cutoff import REPEAT_PAUSE_S, StopFrame
from robotcore.errors import BackendError
from robotcore.hal.cutoff import UnconfirmedStop
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.processes import describe_process
from tests.doubles.serial.board import Powered
from tests.doubles.serial.line import AnsweringBoard
from tests.doubles.serial.pty import Pty
from tests.drivers.serial.boards.motor_program import STOP, TURN
from tests.texts import CheckText, Raises

ROOT = Path(__file__).parents[4]
END_S = 20.0


class Bench:
    """A board on a pty, and a program that turns its motor."""

    def __init__(self, pty: Pty) -> None:
        self.pty, self.clock, self.board = pty, MonotonicClock(), AnsweringBoard()
        self.powered = Powered(self.board, pty, self.clock)
        command = [sys.executable, "-m", "tests.drivers.serial.boards.motor_program", str(pty.path)]
        pipe = subprocess.PIPE
        self.program = subprocess.Popen(command, cwd=ROOT, stdin=pipe, stderr=pipe, text=True)

    def wait_for_frame(self, frame: bytes, action: Callable[[], object] = bool) -> None:
        """Call ``action``, and wait until the board has received ``frame`` since then."""
        before = len(self.board.received)
        action()
        while frame not in self.board.received[before:]:
            self.clock.sleep_until(self.clock.now() + 0.005)
            assert self.clock.now() < END_S, self.board.received[-50:]

    def wait_for_end(self) -> str:
        """Wait until the program and its guardian have ended; return their standard error."""
        return self.program.communicate(timeout=END_S)[1]

    def close(self) -> None:
        self.program.kill()
        self.program.communicate()
        self.powered.off()
        self.clock.close()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with Pty(tmp_path) as pty:
        bench = Bench(pty)
        yield bench
        bench.close()


@pytest.mark.slow
def test_the_guardian_stops_the_board_of_a_killed_program(bench: Bench, check_text: CheckText) -> None:
    bench.wait_for_frame(TURN)
    bench.wait_for_frame(STOP, bench.program.kill)
    output = bench.wait_for_end()
    assert bench.board.received.endswith(STOP)
    check_text(output, hide=[bench.program.pid])


@pytest.mark.slow
def test_a_suspended_programs_board_is_stopped_and_turns_when_it_resumes(bench: Bench) -> None:
    bench.wait_for_frame(TURN)
    bench.wait_for_frame(STOP, partial(bench.program.send_signal, signal.SIGSTOP))
    bench.wait_for_frame(TURN, partial(bench.program.send_signal, signal.SIGCONT))


@pytest.mark.slow
def test_a_replugged_board_is_stopped(bench: Bench) -> None:
    bench.wait_for_frame(TURN)
    bench.pty.unplug()
    bench.wait_for_frame(TURN, bench.pty.plug_in)
    bench.wait_for_frame(STOP, bench.program.kill)
    bench.wait_for_end()
    assert bench.board.received.endswith(STOP)


@pytest.mark.slow
def test_an_unplugged_board_is_left_to_its_own_time_out(bench: Bench, check_text: CheckText) -> None:
    bench.wait_for_frame(TURN)
    bench.pty.unplug()
    bench.program.kill()
    output = bench.wait_for_end()
    check_text(output)


def test_an_unplugged_port_is_closed_so_that_the_board_keeps_its_name(tmp_path: Path) -> None:
    with Pty(tmp_path) as pty:
        cutoff = StopFrame(str(pty.path), 57600, STOP.hex(), "!", has_owner=True)
        cutoff.open()
        name = str(pty.path.resolve())
        pty.unplug()
        _wait_until(lambda: not _count_open_files(f"{name} (deleted)"))
        pty.plug_in()
        cutoff.arm()
        assert _count_open_files(str(pty.path.resolve())) == 2, "one of them the double's"
        cutoff.stop()
        cutoff.close()
        assert pty.read_all() == 2 * STOP


@pytest.fixture
def powered(tmp_path: Path) -> Iterator[Powered]:
    clock = MonotonicClock()
    with Pty(tmp_path) as pty:
        yield (powered := Powered(AnsweringBoard(), pty, clock))
        powered.off()
    clock.close()


def stop_without_run(path: Path, answer: str | None) -> str | None:
    """Stop the board like `robotcore stop`, which has no run."""
    cutoff = StopFrame(str(path), 57600, STOP.hex(), answer, has_owner=False)
    cutoff.open()
    try:
        return cutoff.stop()
    finally:
        cutoff.close()


def test_a_stop_without_a_run_is_confirmed_by_the_board(tmp_path: Path, powered: Powered) -> None:
    assert stop_without_run(tmp_path / "board", "!") is None
    assert isinstance(powered.board, AnsweringBoard)
    assert powered.board.received == 2 * STOP


@pytest.mark.slow
@pytest.mark.parametrize("is_deaf", [True, False])
def test_a_stop_that_the_board_does_not_confirm_is_an_error(
    tmp_path: Path, powered: Powered, monkeypatch: pytest.MonkeyPatch, raises: Raises, *, is_deaf: bool
) -> None:
    monkeypatch.setattr("drivers.serial.boards.cutoff.ANSWER_TIMEOUT_S", 0.5)
    assert isinstance(powered.board, AnsweringBoard)
    powered.board.is_deaf = is_deaf
    with raises(BackendError, "stop-not-confirmed"):
        stop_without_run(tmp_path / "board", "the answer of another board")


@pytest.mark.slow
def test_a_stop_is_sent_again_until_the_board_has_started(tmp_path: Path, powered: Powered) -> None:
    assert isinstance(powered.board, AnsweringBoard)
    powered.board.is_deaf = True
    clock = MonotonicClock()
    clock.call_at(0.4, lambda: setattr(powered.board, "is_deaf", False))
    assert stop_without_run(tmp_path / "board", "!") is None
    assert clock.now() > 0.4
    clock.close()


def test_the_stop_of_a_board_that_never_answers_is_unconfirmed(tmp_path: Path, check_text: CheckText) -> None:
    with Pty(tmp_path) as pty:
        clock = MonotonicClock()
        unconfirmed = stop_without_run(pty.path, None)
        assert clock.now() >= REPEAT_PAUSE_S
        assert isinstance(unconfirmed, UnconfirmedStop)
        check_text(unconfirmed)
        assert pty.read_all() == 2 * STOP


@pytest.mark.slow
def test_a_program_that_has_the_port_open_is_reported_after_the_stop(bench: Bench, check_text: CheckText) -> None:
    bench.wait_for_frame(TURN)
    cutoff = StopFrame(str(bench.pty.path), 57600, STOP.hex(), "!", has_owner=False)
    cutoff.open()

    def stop() -> None:
        with pytest.raises(BackendError) as caught:
            cutoff.stop()
        holders = str(caught.value.fields["holders"])
        assert caught.value.kind == "port-in-use"
        assert holders.startswith(f"{describe_process(bench.program.pid)} and process ")
        assert holders.endswith(" (the guardian of a run)")
        check_text(caught.value, hide=[holders])

    bench.wait_for_frame(STOP, stop)
    cutoff.close()


def test_a_port_that_cannot_be_opened_is_reported_with_a_remedy(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "board").touch()
    with raises(BackendError, "port-not-opened"):
        stop_without_run(tmp_path / "board", None)


def _wait_until(condition: Callable[[], bool]) -> None:
    clock = MonotonicClock()
    while not condition():
        clock.sleep_until(clock.now() + 0.005)
        assert clock.now() < END_S


def _count_open_files(name: str) -> int:
    """Return how often this process has the file ``name`` open."""
    count = 0
    for file in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # closed meanwhile
            count += str(file.readlink()) == name
    return count
