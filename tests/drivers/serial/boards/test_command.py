from __future__ import annotations

import math

from drivers.serial.boards.command import GATHER_S, MAX_AGE_S, STOP_REPEAT_S, CommandBuffer, WheelCommand

TIMEOUT_S = 0.5


def test_a_command_is_taken_once_for_each_time_it_was_sent() -> None:
    command = CommandBuffer()
    for now in (0.0, 1.0):
        command.set("left", 2.0, now)
        command.set("right", 2.0, now)
        assert command.take(now, TIMEOUT_S) == WheelCommand(2.0, 2.0)
        assert command.take(now + 0.5, TIMEOUT_S) is None


def test_one_motor_reported_alone_goes_when_it_has_waited_for_the_other() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    assert command.take(0.0, TIMEOUT_S) is None
    assert command.take(command.next_due, TIMEOUT_S) == WheelCommand(2.0, 0.0)
    assert command.next_due == math.inf


def test_a_motor_reported_again_does_not_wait_longer() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.set("left", 3.0, GATHER_S / 2)
    assert command.take(GATHER_S, TIMEOUT_S) == WheelCommand(3.0, 0.0)


def test_both_are_stopped_in_one_frame() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.set("right", 2.0, 0.0)
    command.take(0.0, TIMEOUT_S)
    command.set("left", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) is None
    command.set("right", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) == WheelCommand()


def test_one_motor_is_stopped_alone_and_at_once_where_the_other_one_stands() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.take(GATHER_S, TIMEOUT_S)
    command.set("left", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) == WheelCommand()


def test_a_stop_does_not_turn_the_other_motor_by_what_it_was_sent_long_ago() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.set("right", 2.0, 0.0)
    command.take(0.0, TIMEOUT_S)
    command.set("left", 0.0, 2 * MAX_AGE_S)
    assert command.take(3 * MAX_AGE_S, TIMEOUT_S) == WheelCommand()


def test_a_motor_that_was_sent_alone_turns_as_long_as_the_boards_time_out_whatever_the_other_one_is_reported() -> None:
    command, taken = CommandBuffer(), []
    command.set("right", 2.0, 0.0)
    command.take(GATHER_S, TIMEOUT_S)
    for now in (0.2, 0.4, 0.6):
        command.set("left", 3.0, now)
        taken.append(command.take(now + GATHER_S, TIMEOUT_S))
    assert taken == [WheelCommand(3.0, 2.0), WheelCommand(3.0, 2.0), WheelCommand(3.0, 0.0)]


def test_nothing_is_left_of_what_is_forgotten() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.clear()
    assert command.take(1.0, TIMEOUT_S) is None
    command.set("right", 3.0, 1.0)
    assert command.take(1.0 + GATHER_S, TIMEOUT_S) == WheelCommand(0.0, 3.0)


def test_what_could_not_be_sent_for_long_turns_nothing_any_more() -> None:
    command = CommandBuffer()
    command.set("left", 2.0, 0.0)
    command.set("right", 2.0, 0.0)
    assert command.take(2 * MAX_AGE_S, TIMEOUT_S) == WheelCommand() == command.newest


def test_who_stands_is_reported_so_again_and_who_turns_is_not() -> None:
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
