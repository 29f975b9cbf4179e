"""No wheel continues to turn after the program is suspended, is killed or ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from tests.system.firmware.backend import start_board
from tests.system.firmware.board import Board
from tests.system.firmware.config import BOARD_TIMEOUT_S, write_rover_file
from tests.system.speed import scaled

STARTED_S, ENDED_S = 30.0, 20.0
"""The longest time until a run drives, and until it ends, in seconds on the reference machine."""

BOOTING_S = 0.5
CONTROL_PERIOD_S = 1 / 30


def has_ended(process: subprocess.Popen[str]) -> bool:
    return process.poll() is not None


@contextmanager
def run_program(
    board: Board, *arguments: str, program: Sequence[str] = ("robotcore",)
) -> Iterator[subprocess.Popen[str]]:
    """Let another process drive a robot over open ground."""
    command = [sys.executable, "-m", *program, "run", "avoid-obstacles", *arguments]
    with subprocess.Popen(command, text=True) as process:
        try:
            board.wait(
                lambda: has_ended(process) or min(map(abs, board.velocities)) > 1.0,
                "the wheels to turn",
                scaled(STARTED_S),
            )
            assert process.poll() is None, f"the run has ended with {process.returncode}"
            yield process
        finally:
            process.kill()


@pytest.fixture
def app(board: Board, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A run whose clock follows the AVR's."""
    rover = str(write_rover_file(tmp_path / "rover.toml"))
    here = ("--backend", "simavr", "--robot", rover, "--option", f"join={board.folder}", "--world", "open")
    with run_program(board, *here, "--set", "duration_s=600", "--timeout", "600") as process:
        yield process


def list_children(app: subprocess.Popen[str]) -> list[int]:
    """Return the child processes of a run."""
    return [int(pid) for pid in Path(f"/proc/{app.pid}/task/{app.pid}/children").read_text().split()]


def test_hung_program_leaves_no_wheel_turning(board: Board, app: subprocess.Popen[str]) -> None:
    app.send_signal(signal.SIGSTOP)
    board.wait_for_stop(2.0)
    board.pass_time(0.5)
    assert board.duties == (0.0, 0.0)


def test_boards_deadman_stops_a_hung_program_with_a_hung_guardian(board: Board, app: subprocess.Popen[str]) -> None:
    hung = [*list_children(app), app.pid]
    assert len(hung) > 1, "the run has no guardian"
    try:
        for pid in hung:
            os.kill(pid, signal.SIGSTOP)
        stopped = board.wait_for_stop(2.0)
        last = [event for event in board.events("line") if event.more.startswith("m ")][-1]
    finally:
        for pid in hung:
            os.kill(pid, signal.SIGCONT)
    assert not last.more.startswith("m 0 0"), "the last command before the stop was a stop"
    assert BOARD_TIMEOUT_S - 0.001 <= stopped.time - last.time <= BOARD_TIMEOUT_S + CONTROL_PERIOD_S


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_program_that_ends_leaves_no_wheel_turning(
    board: Board, app: subprocess.Popen[str], number: signal.Signals
) -> None:
    app.send_signal(number)
    board.wait_for_stop(2.0)
    app.wait(scaled(ENDED_S))
    board.pass_time(0.5)
    assert board.duties == (0.0, 0.0)


def test_run_on_the_serial_backend_drives_and_leaves_the_wheels_at_rest(tmp_path: Path) -> None:
    """Use the shipped rover's section for its board.

    Opening the port does not reset the board, so it already has a range for the first question.
    """
    rover = str(write_rover_file(tmp_path / "rover.toml"))
    with start_board(lambda wiring: replace(wiring, resets_when_opened=False)) as board:
        board.pass_time(BOOTING_S)
        here = ("--backend", "serial", "--robot", rover, "--port", str(board.port))
        program = ("tests.system.firmware.run_in_avr_time", str(board.folder))
        with run_program(board, *here, "--set", "duration_s=2", program=program) as process:
            assert process.wait(scaled(ENDED_S)) == 0
        board.pass_time(0.2)
        assert board.duties == (0.0, 0.0)
