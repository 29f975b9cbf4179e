"""The firmware on its line, without a driver. It answers, counts, turns, and stops by itself."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.system.firmware.backend import start_board
from tests.system.firmware.board import STANDS, Board
from tests.system.firmware.raw import RawLine

CONTROL_PERIOD_S = 1 / 30
COUNTS_A_TURN = 960
COASTED = 20
"""The most counts after the tenth of a second of a bootloader."""


def test_answers(board: Board) -> None:
    with RawLine(board) as line:
        assert line.ask("v") == "robotcore-bridge 1"
        assert line.ask("e") == "0 0"
        assert line.ask("m 20") == line.ask("m 20 x") == line.ask("m 99999 0") == line.ask("?") == "Invalid Command"
    assert not board.events("duty")


@pytest.mark.parametrize("left,right", [(20, 20), (40, -15), (-30, 50)])
def test_each_wheel_reaches_its_speed(board: Board, left: int, right: int) -> None:
    with RawLine(board) as line:
        assert line.ask(f"m {left} {right}") == "OK"
        board.pass_time(1.0)
        before = board.angles
        counted = map(int, line.ask("e").split())
        after = board.angles
        asked = [math.tau * counts / COUNTS_A_TURN / CONTROL_PERIOD_S for counts in (left, right)]
        assert list(board.velocities) == pytest.approx(asked, rel=0.03)
        for count, *angles in zip(counted, before, after, strict=True):
            low, high = sorted(angle * COUNTS_A_TURN / math.tau for angle in angles)
            assert low - 1 <= count <= high + 1


def test_silence_stops_both_wheels_when_the_deadman_is_due(board: Board) -> None:
    with RawLine(board) as line:
        assert (line.ask("k 300"), line.ask("m 20 30")) == ("OK", "OK")
        received = board.events("line")[-1].time
        board.pass_time(0.2)
        assert line.ask("e") != "0 0"
        board.pass_time(1.0)
    last = board.events("duty")[-1]
    assert last.more == STANDS
    assert 0.299 < last.time - received < 0.3 + CONTROL_PERIOD_S


def test_pulled_line_stops_both_wheels_and_they_stand_after_replugging(board: Board) -> None:
    with RawLine(board) as line:
        assert (line.ask("k 500"), line.ask("m 20 20")) == ("OK", "OK")
        board.pass_time(0.3)
        received = board.events("line")[-1].time
        board.pull()
    board.pass_time(1.0)
    stopped = board.events("duty")[-1]
    assert stopped.more == STANDS
    assert stopped.time - received == pytest.approx(0.5, abs=CONTROL_PERIOD_S)
    board.plug()
    with RawLine(board) as line:
        assert line.ask("e") == "0 0"  # opening the port has reset the board
        board.pass_time(0.3)
    assert board.events("duty")[-1] == stopped


def test_reset_board_stands(board: Board) -> None:
    with RawLine(board) as line:
        assert line.ask("m 30 30") == "OK"
        board.pass_time(0.3)
        board.reset()
        board.pass_time(0.6)
        reset = board.events("reset")[-1].time
        stopped = board.events("duty")[-1]
        assert stopped.more == STANDS
        assert stopped.time - reset == pytest.approx(0.0, abs=0.001)
        assert all(int(count) < COASTED for count in line.ask("e").split())


def test_hung_sketch_is_stopped_by_the_watchdog(board: Board) -> None:
    with RawLine(board) as line:
        assert line.ask("m 30 30") == "OK"
        board.pass_time(0.3)
        board.hang()
        hung = board.events("hangs")[-1].time
        board.pass_time(0.6)
        stopped = next(event for event in board.events("duty", since=hung) if event.more == STANDS)
        assert stopped.time - hung < 0.3
        assert not board.events("duty", since=stopped.time + 1e-6)
        assert line.ask("v") == "robotcore-bridge 1"


@pytest.mark.parametrize("distance", [0.05, 0.83, 3.5, math.inf])
def test_sonar_measures_the_range(board: Board, distance: float) -> None:
    board.place_target(distance)
    with RawLine(board) as line:
        board.pass_time(0.2)
        millimetres, age = map(int, line.ask("z").split())
    assert millimetres == (-1 if math.isinf(distance) else pytest.approx(distance * 1000, abs=5))
    assert 0 <= age < 150


def test_battery_is_reported_in_millivolts(board: Board) -> None:
    with RawLine(board) as line:
        for volts in (7.4, 11.1):
            board.set_battery_voltage(volts)
            board.pass_time(0.01)
            assert int(line.ask("y")) == pytest.approx(volts * 1000, abs=50)


def test_board_that_is_not_reset_by_its_port_keeps_its_counts() -> None:
    with start_board(lambda wiring: replace(wiring, resets_when_opened=False)) as board:
        with RawLine(board) as line:
            assert line.ask("m 20 20") == "OK"
            board.pass_time(0.3)
            assert line.ask("m 0 0") == "OK"
        with RawLine(board) as line:
            assert line.ask("e") != "0 0"
