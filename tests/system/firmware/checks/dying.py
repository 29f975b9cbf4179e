"""The program that drives is stopped, killed or ended: no wheel goes on turning."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from robotcore.clock import MonotonicClock
from tests.system.firmware.board import Board
from tests.system.firmware.described import BOARD_TIMEOUT_S, patient, written

STARTED_S = 30.0
REAL_TIME = 0.9
FRAME_S = 1 / 30


def is_over(process: subprocess.Popen[str]) -> bool:
    return process.poll() is not None


@contextmanager
def running(board: Board, *asked: str) -> Iterator[subprocess.Popen[str]]:
    """Let a robot drive over open ground, by a process of its own."""
    command = [sys.executable, "-m", "robotcore", "run", "avoid-obstacles", *asked]
    with subprocess.Popen(command, text=True) as process:
        try:
            board.wait(
                lambda: process.poll() is not None or min(board.velocities) > 1.0, "the robot to drive", STARTED_S
            )
            assert process.poll() is None, f"the run has ended with {process.returncode}"
            yield process
        finally:
            process.kill()


@pytest.fixture
def app(board: Board, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A run whose clock follows the AVR's."""
    rover = str(patient(tmp_path / "rover.toml"))
    here = ("--backend", "simavr", "--robot", rover, "--option", f"join={board.folder}", "--world", "open")
    with running(board, *here, "--set", "duration_s=600", "--timeout", "600") as process:
        yield process


def guardians(app: subprocess.Popen[str]) -> list[int]:
    """Return the processes that a run has started."""
    return [int(pid) for pid in Path(f"/proc/{app.pid}/task/{app.pid}/children").read_text().split()]


def test_hung_program_leaves_no_wheel_turning(board: Board, app: subprocess.Popen[str]) -> None:
    app.send_signal(signal.SIGSTOP)
    board.wait_for_stop(2.0)
    board.pass_time(0.5)
    assert board.duties == (0.0, 0.0)


def test_hung_program_whose_guardian_hangs_too_is_stopped_by_the_boards_own_deadman(
    board: Board, app: subprocess.Popen[str]
) -> None:
    hung = [*guardians(app), app.pid]
    assert len(hung) > 1, "the run has no guardian"
    try:
        for pid in hung:
            os.kill(pid, signal.SIGSTOP)
        stopped = board.wait_for_stop(2.0)
        last = [event for event in board.events("line") if event.more.startswith("m ")][-1]
    finally:
        for pid in hung:
            os.kill(pid, signal.SIGCONT)
    assert not last.more.startswith("m 0 0"), "somebody has told the wheels to stop"
    assert BOARD_TIMEOUT_S - 0.001 <= stopped.time - last.time <= BOARD_TIMEOUT_S + FRAME_S


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_program_that_ends_leaves_no_wheel_turning(
    board: Board, app: subprocess.Popen[str], number: signal.Signals
) -> None:
    app.send_signal(number)
    board.wait_for_stop(2.0)
    app.wait(20)
    board.pass_time(0.5)
    assert board.duties == (0.0, 0.0)


def test_run_on_the_serial_backend_drives_and_leaves_the_wheels_at_rest(board: Board, tmp_path: Path) -> None:
    """In the machine's own time, which only a machine that simulates in real time can be held to."""
    robot, wall, began = written(tmp_path / "robot.toml", board.port), MonotonicClock(), board.now()
    try:
        with running(board, "--backend", "serial", "--robot", str(robot), "--set", "duration_s=2") as process:
            assert process.wait(STARTED_S) == 0
    except AssertionError:
        if (pace := (board.now() - began) / wall.now()) < REAL_TIME:
            pytest.skip(f"the AVR ran at {pace:.2f} of real time: the machine is too busy")
        raise
    board.pass_time(0.2)
    assert board.duties == (0.0, 0.0)
