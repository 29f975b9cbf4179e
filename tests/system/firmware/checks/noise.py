"""A line that damages bytes in both directions. No wheel turns at a velocity that was not commanded."""

from __future__ import annotations

import math
from functools import reduce
from operator import xor

import pytest

from tests.system.firmware.board import Board
from tests.system.firmware.raw import RawLine

RAD_S = math.tau / 960 * 30
"""The velocity of one count per control period, in rad/s."""

OVERSHOOT = 1.2


def with_checksum(command: str) -> bytes:
    return f"{command}*{reduce(xor, command.encode(), 0):02X}\r".encode()


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_noise_does_not_change_the_effect_of_commands_with_checksums(board: Board, share: float) -> None:
    with RawLine(board) as line:
        line.send(with_checksum("k 300"))
        board.set_noise(share)
        fastest = slowest = 0.0
        for _ in range(100):
            line.send(with_checksum("m 20 -20"))
            board.pass_time(0.03)
            left, right = board.velocities
            fastest, slowest = max(fastest, left, -right), min(slowest, left, -right)
    assert slowest == 0
    assert 0 < fastest < 20 * RAD_S * OVERSHOOT
    damaged = [event for event in board.events("line") if not event.more.startswith("m 20 -20*")]
    assert damaged, "there was no noise on the line"


def test_random_bytes_turn_no_wheel(board: Board) -> None:
    with RawLine(board) as line:
        line.send(with_checksum("k 300"))
        board.set_noise(1.0)
        for _ in range(100):
            line.send(b"m 20 40\ro 90 90\r" * 4)
            board.pass_time(0.01)
    assert not board.events("duty")
