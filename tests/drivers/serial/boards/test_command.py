from __future__ import annotations

import math

from drivers.serial.boards.board import GATHER_S, MAX_AGE_S, STOP_REPEAT_S, CommandBuffer, WheelCommand

TIMEOUT_S = 0.5


def set_both(command: CommandBuffer, value: float, now: float) -> CommandBuffer:
    command.set("left", value, now)
    command.set("right", value, now)
    return command


def test_each_command_is_taken_once() -> None:
    command = CommandBuffer()
    for now in (0.0, 1.0):
        set_both(command, 2.0, now)
        assert command.take(now, TIMEOUT_S) == WheelCommand(2.0, 2.0)
        assert command.take(now + 0.5, TIMEOUT_S) is None


def test_a_single_command_is_sent_after_a_wait_for_the_other_motor() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    assert command.take(0.0, TIMEOUT_S) is None
    assert command.take(command.next_due, TIMEOUT_S) == WheelCommand(2.0, 0.0)
    assert command.next_due == math.inf


def test_a_repeated_command_does_not_prolong_the_wait() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.set("left", 3.0, GATHER_S / 2)
    assert command.take(GATHER_S, TIMEOUT_S) == WheelCommand(3.0, 0.0)


def test_one_frame_stops_both_motors() -> None:
    command = set_both(CommandBuffer(), 2.0, 0.0)
    command.take(0.0, TIMEOUT_S)
    command.set("left", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) is None
    command.set("right", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) == WheelCommand()


def test_a_stop_is_sent_at_once_if_the_other_motor_stands() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.take(GATHER_S, TIMEOUT_S)
    command.set("left", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) == WheelCommand()


def test_a_stop_does_not_turn_the_other_motor_by_an_old_command() -> None:
    command = set_both(CommandBuffer(), 2.0, 0.0)
    command.take(0.0, TIMEOUT_S)
    command.set("left", 0.0, 2 * MAX_AGE_S)
    assert command.take(3 * MAX_AGE_S, TIMEOUT_S) == WheelCommand()


def test_a_motor_without_new_commands_turns_for_the_time_out_while_the_other_turns() -> None:
    command, taken = CommandBuffer(), []
    command.set("right", 2.0, 0.0)
    command.take(GATHER_S, TIMEOUT_S)
    for now in (0.2, 0.4, 0.6):
        command.set("left", 3.0, now)
        taken.append(command.take(now + GATHER_S, TIMEOUT_S))
    assert taken == [WheelCommand(3.0, 2.0), WheelCommand(3.0, 2.0), WheelCommand(3.0, 0.0)]


def test_clear_drops_the_command() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.clear()
    assert command.take(1.0, TIMEOUT_S) is None
    command.set("right", 3.0, 1.0)
    assert command.take(1.0 + GATHER_S, TIMEOUT_S) == WheelCommand(0.0, 3.0)


def test_an_old_command_is_sent_as_zero() -> None:
    command = set_both(CommandBuffer(), 2.0, 0.0)
    assert command.take(2 * MAX_AGE_S, TIMEOUT_S) == WheelCommand() == command.newest


def test_only_a_stop_is_repeated() -> None:
    command = CommandBuffer()
    assert command.repeat_stop(0.0) == WheelCommand()
    assert command.repeat_stop(STOP_REPEAT_S / 2) is None
    assert command.repeat_stop(command.repeat_due) == WheelCommand()
    command.set("left", 2.0, 1.0)
    assert command.repeat_stop(1.0) is None
    assert command.repeat_due == math.inf
    command.set("left", 0.0, 2.0)
    assert command.take(2.0, TIMEOUT_S) == WheelCommand()
    assert command.repeat_stop(2.0 + STOP_REPEAT_S / 2) is None
    assert command.repeat_stop(2.0 + STOP_REPEAT_S) == WheelCommand()
