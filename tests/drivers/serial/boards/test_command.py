from __future__ import annotations

import math

from drivers.serial.boards.command import AGAIN_S, GATHERING_S, OLD_S, Command, Told

TIMEOUT_S = 0.5


def test_a_command_is_taken_once_for_each_time_it_was_told() -> None:
    command = Command()
    for now in (0.0, 1.0):
        command.tell("left", 2.0, now)
        command.tell("right", 2.0, now)
        assert command.take(now, TIMEOUT_S) == Told(2.0, 2.0)
        assert command.take(now + 0.5, TIMEOUT_S) is None


def test_one_motor_told_alone_goes_when_it_has_waited_for_the_other() -> None:
    command = Command()
    command.tell("left", 2.0, 0.0)
    assert command.take(0.0, TIMEOUT_S) is None
    assert command.take(command.next_due, TIMEOUT_S) == Told(2.0, 0.0)
    assert command.next_due == math.inf


def test_a_motor_told_again_does_not_wait_longer() -> None:
    command = Command()
    command.tell("left", 2.0, 0.0)
    command.tell("left", 3.0, GATHERING_S / 2)
    assert command.take(GATHERING_S, TIMEOUT_S) == Told(3.0, 0.0)


def test_both_are_stopped_in_one_frame() -> None:
    command = Command()
    command.tell("left", 2.0, 0.0)
    command.tell("right", 2.0, 0.0)
    command.take(0.0, TIMEOUT_S)
    command.tell("left", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) is None
    command.tell("right", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) == Told()


def test_one_motor_is_stopped_alone_and_at_once_where_the_other_one_stands() -> None:
    command = Command()
    command.tell("left", 2.0, 0.0)
    command.take(GATHERING_S, TIMEOUT_S)
    command.tell("left", 0.0, 0.1)
    assert command.take(0.1, TIMEOUT_S) == Told()


def test_a_stop_does_not_turn_the_other_motor_by_what_it_was_told_long_ago() -> None:
    command = Command()
    command.tell("left", 2.0, 0.0)
    command.tell("right", 2.0, 0.0)
    command.take(0.0, TIMEOUT_S)
    command.tell("left", 0.0, 2 * OLD_S)
    assert command.take(3 * OLD_S, TIMEOUT_S) == Told()


def test_a_motor_that_was_told_alone_turns_as_long_as_the_boards_time_out_whatever_the_other_one_is_told() -> None:
    command, told = Command(), []
    command.tell("right", 2.0, 0.0)
    command.take(GATHERING_S, TIMEOUT_S)
    for now in (0.2, 0.4, 0.6):
        command.tell("left", 3.0, now)
        told.append(command.take(now + GATHERING_S, TIMEOUT_S))
    assert told == [Told(3.0, 2.0), Told(3.0, 2.0), Told(3.0, 0.0)]


def test_nothing_is_left_of_what_is_forgotten() -> None:
    command = Command()
    command.tell("left", 2.0, 0.0)
    command.forget()
    assert command.take(1.0, TIMEOUT_S) is None
    command.tell("right", 3.0, 1.0)
    assert command.take(1.0 + GATHERING_S, TIMEOUT_S) == Told(0.0, 3.0)


def test_what_could_not_be_sent_for_long_turns_nothing_any_more() -> None:
    command = Command()
    command.tell("left", 2.0, 0.0)
    command.tell("right", 2.0, 0.0)
    assert command.take(2 * OLD_S, TIMEOUT_S) == Told() == command.told


def test_who_stands_is_told_so_again_and_who_turns_is_not() -> None:
    command = Command()
    assert command.again(0.0) == Told()
    assert command.again(AGAIN_S / 2) is None
    assert command.again(command.again_due) == Told()
    command.tell("left", 2.0, 1.0)
    assert command.again(1.0) is None
    assert command.again_due == math.inf
    command.tell("left", 0.0, 2.0)
    assert command.take(2.0, TIMEOUT_S) == Told()
    assert command.again(2.0 + AGAIN_S / 2) is None
    assert command.again(2.0 + AGAIN_S) == Told()
