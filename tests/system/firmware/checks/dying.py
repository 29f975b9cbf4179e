"""The program that drives is stopped, killed or ended: no wheel goes on turning."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.system.firmware.board import Board
from tests.system.firmware.described import written

RUN = "run avoid-obstacles --backend serial --set duration_s=600 --timeout 600"
STARTED_S = 30.0
BOARD_TIMEOUT_S = 0.5
FRAME_S = 1 / 30


@pytest.fixture
def app(board: Board, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A run on the backend `serial`, in a process of its own, whose robot drives over open ground."""
    robot = written(tmp_path / "robot.toml", board.port)
    command = [sys.executable, "-m", "robotcore", *RUN.split(), "--robot", str(robot)]
    with subprocess.Popen(command, text=True) as process:
        try:
            board.wait(lambda: min(board.velocities) > 1.0, "the robot to drive", STARTED_S)
            yield process
        finally:
            process.kill()


def wait_for_stop(board: Board) -> float:
    """Return how long after the last command the motors were stopped."""
    board.wait(lambda: board.duties == (0.0, 0.0), "the wheels to be stopped", 2.0)
    commands = [event for event in board.events("line") if event.more.startswith("m ")]
    return board.events("duty")[-1].time - commands[-1].time


def test_hung_program_is_stopped_by_the_boards_own_deadman(board: Board, app: subprocess.Popen[str]) -> None:
    app.send_signal(signal.SIGSTOP)
    assert wait_for_stop(board) <= BOARD_TIMEOUT_S + FRAME_S
    board.pass_time(0.5)
    assert board.duties == (0.0, 0.0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_program_that_ends_leaves_no_wheel_turning(
    board: Board, app: subprocess.Popen[str], number: signal.Signals
) -> None:
    app.send_signal(number)
    wait_for_stop(board)
    app.wait(20)
    board.pass_time(0.5)
    assert board.duties == (0.0, 0.0)
