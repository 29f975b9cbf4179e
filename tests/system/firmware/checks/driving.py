"""Failures during a drive. The firmware stops the wheels, and the drivers raise and recover."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest

from robotcore.errors import DeviceError, DeviceGroupError, DeviceLostError
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.battery import Battery
from robotcore.kinds.encoder import Encoder
from robotcore.testing import worlds
from tests.system.firmware.backend import SimavrBackend
from tests.system.firmware.board import STANDS, Board
from tests.system.firmware.config import BOARD_TIMEOUT_S, load_rover_with_battery

DEVICES = frozenset({"left_motor", "right_motor", "left_encoder", "right_encoder", "battery"})
SPEED_RAD_S = 5.0
TICK_S = 0.05
CONTROL_PERIOD_S = 1 / 30
NOISY_S = 6.0
STANDING_RAD_S = 0.05
OVERSHOOT = 1.25
BACK_S = 10.0
"""The longest time until a replugged board drives again, in seconds: back-off, bootloader and first answers."""


@pytest.fixture
def robot(board: Board) -> Iterator[Robot]:
    opened = SimavrBackend(board).open(Setup(load_rover_with_battery(), worlds.empty(), DEVICES))
    try:
        yield opened
    finally:
        with suppress(DeviceError, DeviceGroupError):  # closing raises if the board is unplugged
            opened.close()


def drive(robot: Robot, left: float = SPEED_RAD_S, right: float = SPEED_RAD_S) -> None:
    """Command both wheels, as an app does in a tick."""
    robot.motors["left_motor"].set_velocity(left)
    robot.motors["right_motor"].set_velocity(right)


def drive_for(robot: Robot, seconds: float, left: float = SPEED_RAD_S, right: float = SPEED_RAD_S) -> None:
    end = robot.clock.now() + seconds
    while robot.clock.now() < end:
        drive(robot, left, right)
        robot.clock.sleep_until(robot.clock.now() + TICK_S)


def drive_until(robot: Robot, is_true: Callable[[], bool], within_s: float = BACK_S) -> None:
    """Command both wheels, despite errors, until a condition is true."""
    end = robot.clock.now() + within_s
    while not is_true():
        assert robot.clock.now() < end, f"waited {within_s} s"
        if not is_lost(robot):
            drive(robot)
        robot.clock.sleep_until(robot.clock.now() + TICK_S)


def is_lost(robot: Robot) -> bool:
    try:
        drive(robot)
    except DeviceLostError:
        return True
    return False


def is_turning(board: Board) -> bool:
    return min(board.velocities) > SPEED_RAD_S / 2


def last_turning_command(board: Board, before: float = math.inf) -> float:
    """Return the time of the last whole command that feeds the deadman."""
    commands = [event for event in board.events("line") if event.more[:2] in ("m ", "o ") and event.time < before]
    return commands[-1].time


def test_battery_is_reported_in_volts(robot: Robot, board: Board) -> None:
    battery = robot["battery"]
    assert isinstance(battery, Battery)
    for volts in (7.4, 6.6):
        board.set_battery_voltage(volts)
        robot.clock.sleep_until(robot.clock.now() + 1.5)
        assert battery.read().voltage == pytest.approx(volts, abs=0.05)


def test_pulled_line_stops_the_wheels_by_the_boards_own_deadman(robot: Robot, board: Board) -> None:
    drive_for(robot, 0.5)
    assert is_turning(board)
    board.pull()
    pulled = board.events("pulled")[-1].time
    commanded = last_turning_command(board)
    board.wait(lambda: is_lost(robot), "the loss to be raised", 1.0)
    assert board.velocities.left > STANDING_RAD_S, "the board has stopped before its deadman was due"
    stopped = board.wait_for_stop(1.0)
    assert commanded < pulled < stopped.time
    assert BOARD_TIMEOUT_S - 0.001 <= stopped.time - commanded <= BOARD_TIMEOUT_S + CONTROL_PERIOD_S


def test_replugged_board_stands_until_a_new_command(robot: Robot, board: Board) -> None:
    drive_for(robot, 0.5)
    board.pull()
    board.wait(lambda: is_lost(robot), "the loss to be raised", 1.0)
    stopped = board.wait_for_stop(1.0).time
    board.plug()
    board.pass_time(4.0)
    assert [event for event in board.events("duty", since=stopped + 0.001) if event.more != STANDS] == []
    drive_until(robot, lambda: is_turning(board))


def test_encoders_continue_after_a_reset_of_the_board(robot: Robot, board: Board) -> None:
    drive_for(robot, 1.0)
    encoder = robot["left_encoder"]
    assert isinstance(encoder, Encoder)
    before = encoder.read().angle
    board.reset()
    board.wait(lambda: max(board.velocities) < STANDING_RAD_S, "the wheels to stand", 1.0)
    drive_until(robot, lambda: is_turning(board))
    after = encoder.read().angle
    assert 0 < before <= after + 0.1
    assert after < board.angles.left + 0.1


def test_hung_sketch_is_reset_by_its_watchdog_and_driven_again(robot: Robot, board: Board) -> None:
    drive_for(robot, 0.5)
    board.hang()
    board.wait_for_stop(0.5)
    board.wait(lambda: not is_turning(board), "the wheels to run out", 0.5)
    drive_until(robot, lambda: bool(board.events("watchdog")) and is_turning(board))
    reset = board.events("watchdog")[-1].time
    deadmen = [event for event in board.events("line", since=reset) if event.more.startswith("k 500")]
    turned = next(event for event in board.events("duty", since=reset) if event.more != STANDS)
    assert deadmen, "wheels turn without a new time-out of the deadman"
    assert deadmen[0].time < turned.time


@pytest.mark.parametrize("share", [0.005, 0.02])
def test_noise_in_both_directions_changes_no_command(robot: Robot, board: Board, share: float) -> None:
    board.set_noise(share)
    fastest = slowest = 0.0
    begun = robot.clock.now()
    while robot.clock.now() < begun + NOISY_S or fastest < SPEED_RAD_S / 2:
        assert robot.clock.now() < begun + BACK_S + NOISY_S, "nothing came through"
        is_lost(robot)
        robot.clock.sleep_until(robot.clock.now() + 0.02)
        fastest, slowest = max(fastest, *board.velocities), min(slowest, *board.velocities)
    assert slowest == 0
    assert fastest < SPEED_RAD_S * OVERSHOOT
    board.set_noise(0.0)
    drive_until(robot, lambda: board.velocities == pytest.approx((SPEED_RAD_S, SPEED_RAD_S), rel=0.05))
