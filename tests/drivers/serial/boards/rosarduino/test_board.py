from __future__ import annotations

import pytest

from drivers.serial.boards.rosarduino.protocol import ping
from drivers.serial.boards.rosarduino.requests import Poll
from tests.doubles.serial.rosarduino import RosArduinoBridgeDouble
from tests.drivers.serial.boards.rosarduino.rig import HELLO, OURS, TRUE, Conversation, answered, asked
from tests.texts import CheckText

LOST_S = 0.11
"""After this time an answer is lost."""


@pytest.fixture
def ours() -> Conversation:
    conversation = Conversation()
    conversation.meet_ours()
    return conversation


@pytest.fixture
def true_one() -> Conversation:
    conversation = Conversation()
    conversation.meet_the_true_one()
    return conversation


def test_robotcore_bridge_is_identified_by_its_name(ours: Conversation) -> None:
    assert ours.protocol.is_ready
    assert ours.protocol.firmware.is_robotcore_bridge
    assert ours.protocol.firmware.frame_s == pytest.approx(1 / 30)


def test_ros_arduino_bridge_is_identified_by_its_speed_alone(true_one: Conversation, check_text: CheckText) -> None:
    assert true_one.protocol.is_ready
    assert not true_one.protocol.firmware.is_robotcore_bridge
    assert true_one.protocol.firmware.frame_s == 0.033
    assert not true_one.protocol.firmware.takes_duties
    check_text(true_one.protocol.timeout_notice)


def test_one_noisy_answer_does_not_identify_ros_arduino_bridge() -> None:
    conversation = Conversation()
    conversation.goes((HELLO, TRUE), (HELLO, OURS), (asked("m 0 0"), answered("OK")))
    assert conversation.protocol.firmware.is_robotcore_bridge


def test_a_misidentified_robotcore_bridge_is_probed_again_after_refusals(true_one: Conversation) -> None:
    refused = b"Invalid Command\r\n"
    for _ in range(2):
        true_one.set(20, 20)
        true_one.goes((b"m 20 20\r", refused))
    assert not true_one.protocol.is_ready
    true_one.goes((HELLO, OURS), (asked("m 0 0"), answered("OK")), (asked("k 2000"), answered("OK")))
    true_one.set(20, 20)
    true_one.goes((asked("m 20 20"), answered("OK")))


def test_a_ros_arduino_bridge_without_wheels_is_reported() -> None:
    conversation = Conversation()
    refused = b"Invalid Command\r\n"
    conversation.goes((HELLO, TRUE), (HELLO, TRUE), (b"m 0 0\r", refused), (b"m 0 0\r", refused))
    assert not conversation.protocol.firmware.has_wheels


def test_another_version_of_robotcore_bridge_is_reported() -> None:
    conversation = Conversation()
    conversation.goes((HELLO, b"OK\r\n" + answered("robotcore-bridge 2")))
    assert conversation.protocol.firmware.fault


def test_the_time_out_is_sent_before_anything_turns(ours: Conversation, check_text: CheckText) -> None:
    ours.protocol.limit(0.5)
    ours.set(20, 20)
    ours.goes((asked("k 500"), answered("OK")), (asked("m 20 20"), answered("OK")))
    check_text(ours.protocol.timeout_notice)


def test_the_shortest_time_out_of_all_motors_counts(ours: Conversation) -> None:
    ours.protocol.limit(1.0)
    ours.protocol.limit(0.3)
    ours.goes((asked("k 300"), answered("OK")))


def test_only_the_newest_command_is_sent_and_each_once(ours: Conversation) -> None:
    assert ours.sent(0.06) == asked("e")
    ours.set(10, 10)
    ours.set(20, -20)
    assert ours.sent() == b""
    ours.answer(answered("0 0"))
    ours.goes((asked("m 20 -20"), answered("OK")))
    assert ours.sent() == b""
    ours.set(20, -20)
    ours.goes((asked("m 20 -20"), answered("OK")))


@pytest.mark.parametrize("left, right", [(20, 20), (0, 20)])
def test_a_turning_command_without_acknowledgement_is_not_repeated(ours: Conversation, left: int, right: int) -> None:
    ours.set(left, right)
    assert ours.sent() == asked(f"m {left} {right}")
    assert ours.sent(LOST_S) == b"\r" + asked("v")
    ours.answer(answered("robotcore-bridge 1"))
    ours.goes((asked("k 2000"), answered("OK")), (asked("e"), answered("0 0")))
    assert not ours.protocol.is_settled


def test_a_stop_is_repeated_until_it_is_acknowledged(ours: Conversation) -> None:
    ours.set(20, 20)
    ours.goes((asked("m 20 20"), answered("OK")))
    ours.set(0, 0)
    stop = asked("m 0 0")
    ours.goes((stop, answered("Invalid Command")))
    assert not ours.protocol.is_settled
    ours.goes((stop, answered("OK")))
    assert ours.protocol.is_settled


def test_a_command_is_not_settled_before_it_was_sent(ours: Conversation) -> None:
    ours.set(0, 0)
    assert not ours.protocol.is_settled


def test_a_stop_does_not_wait_for_a_slow_answer(ours: Conversation) -> None:
    assert ours.sent(0.06) == asked("e")
    ours.set(0, 0)
    assert ours.sent() == b""
    assert ours.sent(0.02) == b"\rm 0 0\r"
    ours.answer(answered("7 7") + b"OK\r\n")
    ours.goes(
        (b"\r" + asked("v"), answered("robotcore-bridge 1")),
        (asked("m 0 0"), answered("OK")),
        (asked("k 2000"), answered("OK")),
    )


def test_an_answer_that_comes_late_is_not_taken_for_the_next_one(true_one: Conversation) -> None:
    assert true_one.sent(0.06) == b"e\r"
    assert true_one.sent(LOST_S) == b"\rb\r"
    true_one.answer(b"500 500\r\nInvalid Command\r\n")
    assert true_one.sent() == b""
    true_one.answer(b"57600\r\n")
    true_one.goes((b"e\r", b"3 3\r\n"))
    assert true_one.angle == 3


def test_a_board_that_is_slow_is_waited_for_longer_once_an_answer_was_late(ours: Conversation) -> None:
    assert ours.sent(0.06) == asked("e")
    assert ours.sent(LOST_S) == b"\r" + asked("v")
    ours.answer(answered("1 0") + answered("robotcore-bridge 1"))
    ours.goes((asked("k 2000"), b""))
    assert ours.sent(2 * LOST_S) == b""
    ours.answer(answered("OK"))
    assert ours.sent() == asked("e")
    assert ours.sent(2 * LOST_S) == b""
    ours.answer(answered("7 0"))
    assert ours.angle == 7
    assert ours.sent() == asked("e")
    ours.answer(answered("8 0"))
    assert ours.sent(0.06) == asked("e")
    assert ours.sent(LOST_S) == b"\r" + asked("v")


@pytest.mark.parametrize(
    "noise",
    [b"8 8*00\r\n", b"8 8\r\n", b"OK*04\r\n", b"\xff8 8*10\r\n", b"\n\n\r\n", b"9" * 100 + b" 8*10\r\n", b"8 8*10"],
    ids=["wrong sum", "no sum", "other shape", "no letter", "empty", "too long", "cut"],
)
def test_a_line_that_is_no_answer_is_dropped(ours: Conversation, noise: bytes) -> None:
    assert ours.sent(0.06) == asked("e")
    ours.answer(noise + b"\n")
    ours.answer(answered("5 5"))
    if noise != b"8 8*10":  # the line was completed, and is valid
        assert ours.angle == 5


@pytest.mark.parametrize("counts", ["99999999999 0", "4294967296 0", "-2147483649 0"])
def test_a_count_beyond_32_bits_is_dropped(ours: Conversation, counts: str) -> None:
    ours.sent(0.06)
    ours.answer(answered(counts))
    assert ours.angle == 0


def test_a_board_after_a_short_reset_has_its_time_out_before_it_turns(ours: Conversation) -> None:
    ours.protocol.limit(0.5)
    ours.goes((asked("k 500"), answered("OK")))
    assert ours.sent(0.06) == asked("e")
    ours.set(20, 20)
    assert ours.sent(LOST_S) == b"\r" + asked("v")
    ours.answer(b"\x00" + answered("robotcore-bridge 1") + answered("robotcore-bridge 1"))
    ours.goes((asked("k 500"), answered("OK")), (asked("m 20 20"), answered("OK")))


def test_a_silent_board_is_lost_and_its_command_dropped(ours: Conversation) -> None:
    ours.set(20, 20)
    assert ours.sent() == asked("m 20 20")
    ours.set(30, 30)
    while ours.protocol.is_ready:
        sent = ours.sent(0.02)
    assert sent == HELLO
    ours.answer(OURS)
    ours.goes((asked("m 0 0"), answered("OK")), (asked("k 2000"), answered("OK")), (asked("e"), answered("0 0")))
    assert ours.protocol.is_ready


@pytest.mark.parametrize("has_sonar, within_s", [(False, 0.55), (True, 1.65)])
def test_a_board_whose_answers_are_lost_is_stopped_while_the_app_drives_on(
    true_one: Conversation, has_sonar: bool, within_s: float
) -> None:
    board, lost_at = RosArduinoBridgeDouble(), true_one.now
    if has_sonar:
        true_one.protocol.poll(Poll(ping(7), 0.1, lambda _answer, _now: None))
    while true_one.now - lost_at < within_s:
        if true_one.protocol.is_ready:
            true_one.set(20, 20)
        board.receive(true_one.sent(), true_one.now)
    assert "m 20 20" in board.commands
    assert board.wheels.left.command == board.wheels.right.command == 0


def test_a_board_that_is_not_there_yet_is_greeted_again_and_again() -> None:
    conversation = Conversation()
    assert conversation.sent() == HELLO
    assert conversation.sent(0.25) == b""
    assert conversation.sent(0.06) == HELLO
    conversation.answer(b"\x00\x80" + OURS)
    assert conversation.protocol.is_ready


def test_motors_by_duty_are_scaled_to_255(ours: Conversation) -> None:
    ours.protocol.is_duty_mode = True
    ours.set(1.0, -0.25)
    ours.goes((asked("o 255 -64"), answered("OK")))
    ours.set(0, 0)
    ours.goes((asked("m 0 0"), answered("OK")))
