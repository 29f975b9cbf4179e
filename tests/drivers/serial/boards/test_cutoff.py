"""Programs that leave a motor on a board turning, with a real guardian and its stop frame on a pty."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

from drivers.serial.boards.cutoff import APART_S, StopFrame
from robotcore.clock import MonotonicClock
from robotcore.errors import BackendError
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.drivers.serial.boards.turning import STOP, TURN
from tests.drivers.serial.ports.talking import Answering

ROOT = Path(__file__).parents[4]
END_S = 20.0


class Bench:
    """A board on a pty, and a program that turns its motor."""

    def __init__(self, pty: Pty) -> None:
        self.pty, self.clock, self.board = pty, MonotonicClock(), Answering()
        self.powered = Powered(self.board, pty, self.clock)
        command = [sys.executable, "-m", "tests.drivers.serial.boards.turning", str(pty.path)]
        pipe = subprocess.PIPE
        self.program = subprocess.Popen(command, cwd=ROOT, stdin=pipe, stderr=pipe, text=True)

    def until_heard(self, frame: bytes, do: Callable[[], object] = bool) -> None:
        """Do something, and wait until the board is told this."""
        before = len(self.board.heard)
        do()
        while frame not in self.board.heard[before:]:
            self.clock.sleep_until(self.clock.now() + 0.005)
            assert self.clock.now() < END_S, self.board.heard[-50:]

    def over(self) -> str:
        """Return what was said, once neither the program nor its guardian is there any more."""
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


def test_the_board_of_a_killed_program_is_told_to_stop(bench: Bench) -> None:
    bench.until_heard(TURN)
    bench.until_heard(STOP, bench.program.kill)
    said = bench.over()
    assert bench.board.heard.endswith(STOP)
    assert said == f"guardian: the run of process {bench.program.pid} broke off; stopped left_motor\n"


def test_the_board_of_a_suspended_program_is_told_to_stop_and_turns_when_it_goes_on(bench: Bench) -> None:
    bench.until_heard(TURN)
    bench.until_heard(STOP, partial(bench.program.send_signal, signal.SIGSTOP))
    bench.until_heard(TURN, partial(bench.program.send_signal, signal.SIGCONT))


def test_a_board_that_was_plugged_in_again_is_told_to_stop(bench: Bench) -> None:
    bench.until_heard(TURN)
    bench.pty.unplug()
    bench.until_heard(TURN, bench.pty.plug_in)
    bench.until_heard(STOP, bench.program.kill)
    bench.over()
    assert bench.board.heard.endswith(STOP)


def test_a_board_that_was_unplugged_is_left_to_its_own_time_out(bench: Bench) -> None:
    bench.until_heard(TURN)
    bench.pty.unplug()
    bench.program.kill()
    said = bench.over()
    assert f"guardian: {bench.pty.path} is gone: the board stops its motors by itself" in said


def test_a_port_that_is_unplugged_is_let_go_lest_the_board_come_back_by_another_name(tmp_path: Path) -> None:
    with Pty(tmp_path) as pty:
        cutoff = StopFrame(str(pty.path), 57600, STOP.hex(), has_owner=True)
        cutoff.open()
        name = str(pty.path.resolve())
        pty.unplug()
        _until(lambda: not _times_open(f"{name} (deleted)"))
        pty.plug_in()
        cutoff.arm()
        assert _times_open(str(pty.path.resolve())) == 2, "one of them the double's"
        cutoff.stop()
        cutoff.close()
        assert pty.all_heard() == 2 * STOP


def test_where_nobody_drives_the_board_is_told_to_stop_twice_apart_and_that_is_all(tmp_path: Path) -> None:
    with Pty(tmp_path) as pty:
        cutoff = StopFrame(str(pty.path), 57600, STOP.hex(), has_owner=False)
        cutoff.open()
        clock = MonotonicClock()
        began = clock.now()
        cutoff.stop()
        assert clock.now() - began >= APART_S
        clock.close()
        cutoff.close()
        assert pty.all_heard() == 2 * STOP


def test_a_program_that_has_the_port_is_told_of_after_the_stop(bench: Bench) -> None:
    bench.until_heard(TURN)
    cutoff = StopFrame(str(bench.pty.path), 57600, STOP.hex(), has_owner=False)
    cutoff.open()

    def stop() -> None:
        with pytest.raises(BackendError, match=rf"is held by process {bench.program.pid} \(.*End that program first"):
            cutoff.stop()

    bench.until_heard(STOP, stop)
    cutoff.close()


def _until(is_so: Callable[[], bool]) -> None:
    clock = MonotonicClock()
    while not is_so():
        clock.sleep_until(clock.now() + 0.005)
        assert clock.now() < END_S


def _times_open(name: str) -> int:
    """Return how often this process has a file open."""
    found = 0
    for file in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # closed meanwhile
            found += str(file.readlink()) == name
    return found
