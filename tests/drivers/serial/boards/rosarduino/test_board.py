from __future__ import annotations

import pytest

from drivers.serial.boards.rosarduino.protocol import ping
from tests.doubles.serial.rosarduino import RosArduinoBridgeDouble
from tests.drivers.serial.boards.rosarduino.rig import (
    PROBE,
    ROBOTCORE_BRIDGE_REPLY,
    ROS_ARDUINO_BRIDGE_REPLY,
    ScriptedBoard,
    encode_reply,
    encode_request,
)
from tests.texts import CheckText

LATE_S = 0.11
"""A time after which a request without a reply times out, in seconds."""


@pytest.fixture
def robotcore_bridge() -> ScriptedBoard:
    board = ScriptedBoard()
    board.identify_robotcore_bridge()
    return board


@pytest.fixture
def ros_arduino_bridge() -> ScriptedBoard:
    board = ScriptedBoard()
    board.identify_ros_arduino_bridge()
    return board


def test_robotcore_bridge_is_identified_by_its_name(robotcore_bridge: ScriptedBoard) -> None:
    assert robotcore_bridge.protocol.is_ready
    assert robotcore_bridge.protocol.firmware.is_robotcore_bridge
    assert robotcore_bridge.protocol.firmware.control_period_s == pytest.approx(1 / 30)


def test_ros_arduino_bridge_is_identified_by_its_baud_rate(
    ros_arduino_bridge: ScriptedBoard, check_text: CheckText
) -> None:
    assert ros_arduino_bridge.protocol.is_ready
    assert not ros_arduino_bridge.protocol.firmware.is_robotcore_bridge
    assert ros_arduino_bridge.protocol.firmware.control_period_s == 0.033
    assert not ros_arduino_bridge.protocol.firmware.takes_duties
    check_text(ros_arduino_bridge.protocol.timeout_notice)


def test_one_noisy_reply_does_not_identify_ros_arduino_bridge() -> None:
    board = ScriptedBoard()
    board.exchange(
        (PROBE, ROS_ARDUINO_BRIDGE_REPLY),
        (PROBE, ROBOTCORE_BRIDGE_REPLY),
        (encode_request("m 0 0"), encode_reply("OK")),
    )
    assert board.protocol.firmware.is_robotcore_bridge


def test_a_misidentified_robotcore_bridge_is_probed_again_after_refusals(ros_arduino_bridge: ScriptedBoard) -> None:
    refused = b"Invalid Command\r\n"
    for _ in range(2):
        ros_arduino_bridge.set(20, 20)
        ros_arduino_bridge.exchange((b"m 20 20\r", refused))
    assert not ros_arduino_bridge.protocol.is_ready
    ros_arduino_bridge.exchange(
        (PROBE, ROBOTCORE_BRIDGE_REPLY),
        (encode_request("m 0 0"), encode_reply("OK")),
        (encode_request("k 2000"), encode_reply("OK")),
    )
    ros_arduino_bridge.set(20, 20)
    ros_arduino_bridge.exchange((encode_request("m 20 20"), encode_reply("OK")))


def test_a_ros_arduino_bridge_without_wheels_is_reported() -> None:
    board = ScriptedBoard()
    refused = b"Invalid Command\r\n"
    board.exchange(
        (PROBE, ROS_ARDUINO_BRIDGE_REPLY),
        (PROBE, ROS_ARDUINO_BRIDGE_REPLY),
        (b"m 0 0\r", refused),
        (b"m 0 0\r", refused),
    )
    assert not board.protocol.firmware.has_wheels


def test_another_version_of_robotcore_bridge_is_reported() -> None:
    board = ScriptedBoard()
    board.exchange((PROBE, b"OK\r\n" + encode_reply("robotcore-bridge 2")))
    assert board.protocol.firmware.version == 2


def test_the_time_out_is_sent_before_a_motor_turns(robotcore_bridge: ScriptedBoard, check_text: CheckText) -> None:
    robotcore_bridge.protocol.limit(0.5)
    robotcore_bridge.set(20, 20)
    robotcore_bridge.exchange(
        (encode_request("k 500"), encode_reply("OK")), (encode_request("m 20 20"), encode_reply("OK"))
    )
    check_text(robotcore_bridge.protocol.timeout_notice)


def test_the_shortest_time_out_of_all_motors_applies_to_the_board(robotcore_bridge: ScriptedBoard) -> None:
    robotcore_bridge.protocol.limit(1.0)
    robotcore_bridge.protocol.limit(0.3)
    robotcore_bridge.exchange((encode_request("k 300"), encode_reply("OK")))


def test_only_the_newest_command_is_sent_and_only_once(robotcore_bridge: ScriptedBoard) -> None:
    assert robotcore_bridge.next_data(0.06) == encode_request("e")
    robotcore_bridge.set(10, 10)
    robotcore_bridge.set(20, -20)
    assert robotcore_bridge.next_data() == b""
    robotcore_bridge.reply(encode_reply("0 0"))
    robotcore_bridge.exchange((encode_request("m 20 -20"), encode_reply("OK")))
    assert robotcore_bridge.next_data() == b""
    robotcore_bridge.set(20, -20)
    robotcore_bridge.exchange((encode_request("m 20 -20"), encode_reply("OK")))


@pytest.mark.parametrize("left, right", [(20, 20), (0, 20)])
def test_a_turning_command_without_acknowledgement_is_not_repeated(
    robotcore_bridge: ScriptedBoard, left: int, right: int
) -> None:
    robotcore_bridge.set(left, right)
    assert robotcore_bridge.next_data() == encode_request(f"m {left} {right}")
    assert robotcore_bridge.next_data(LATE_S) == b"\r" + encode_request("v")
    robotcore_bridge.reply(encode_reply("robotcore-bridge 1"))
    robotcore_bridge.exchange(
        (encode_request("k 2000"), encode_reply("OK")), (encode_request("e"), encode_reply("0 0"))
    )
    assert not robotcore_bridge.protocol.is_settled


def test_a_stop_is_repeated_until_it_is_acknowledged(robotcore_bridge: ScriptedBoard) -> None:
    robotcore_bridge.set(20, 20)
    robotcore_bridge.exchange((encode_request("m 20 20"), encode_reply("OK")))
    robotcore_bridge.set(0, 0)
    stop = encode_request("m 0 0")
    robotcore_bridge.exchange((stop, encode_reply("Invalid Command")))
    assert not robotcore_bridge.protocol.is_settled
    robotcore_bridge.exchange((stop, encode_reply("OK")))
    assert robotcore_bridge.protocol.is_settled


def test_a_command_is_not_settled_before_it_was_sent(robotcore_bridge: ScriptedBoard) -> None:
    robotcore_bridge.set(0, 0)
    assert not robotcore_bridge.protocol.is_settled


def test_a_stop_does_not_wait_for_a_slow_reply(robotcore_bridge: ScriptedBoard) -> None:
    assert robotcore_bridge.next_data(0.06) == encode_request("e")
    robotcore_bridge.set(0, 0)
    assert robotcore_bridge.next_data() == b""
    assert robotcore_bridge.next_data(0.02) == b"\rm 0 0\r"
    robotcore_bridge.reply(encode_reply("7 7") + b"OK\r\n")
    robotcore_bridge.exchange(
        (b"\r" + encode_request("v"), encode_reply("robotcore-bridge 1")),
        (encode_request("m 0 0"), encode_reply("OK")),
        (encode_request("k 2000"), encode_reply("OK")),
    )


def test_a_late_reply_is_not_taken_for_the_next_reply(ros_arduino_bridge: ScriptedBoard) -> None:
    assert ros_arduino_bridge.next_data(0.06) == b"e\r"
    assert ros_arduino_bridge.next_data(LATE_S) == b"\rb\r"
    ros_arduino_bridge.reply(b"500 500\r\nInvalid Command\r\n")
    assert ros_arduino_bridge.next_data() == b""
    ros_arduino_bridge.reply(b"57600\r\n")
    ros_arduino_bridge.exchange((b"e\r", b"3 3\r\n"))
    assert ros_arduino_bridge.angle == 3


def test_the_wait_for_a_reply_is_longer_after_a_late_reply(robotcore_bridge: ScriptedBoard) -> None:
    assert robotcore_bridge.next_data(0.06) == encode_request("e")
    assert robotcore_bridge.next_data(LATE_S) == b"\r" + encode_request("v")
    robotcore_bridge.reply(encode_reply("1 0") + encode_reply("robotcore-bridge 1"))
    robotcore_bridge.exchange((encode_request("k 2000"), b""))
    assert robotcore_bridge.next_data(2 * LATE_S) == b""
    robotcore_bridge.reply(encode_reply("OK"))
    assert robotcore_bridge.next_data() == encode_request("e")
    assert robotcore_bridge.next_data(2 * LATE_S) == b""
    robotcore_bridge.reply(encode_reply("7 0"))
    assert robotcore_bridge.angle == 7
    assert robotcore_bridge.next_data() == encode_request("e")
    robotcore_bridge.reply(encode_reply("8 0"))
    assert robotcore_bridge.next_data(0.06) == encode_request("e")
    assert robotcore_bridge.next_data(LATE_S) == b"\r" + encode_request("v")


@pytest.mark.parametrize(
    "noise",
    [b"8 8*00\r\n", b"8 8\r\n", b"OK*04\r\n", b"\xff8 8*10\r\n", b"\n\n\r\n", b"9" * 100 + b" 8*10\r\n", b"8 8*10"],
    ids=["wrong sum", "no sum", "other shape", "no letter", "empty", "too long", "cut"],
)
def test_a_line_that_is_no_reply_is_dropped(robotcore_bridge: ScriptedBoard, noise: bytes) -> None:
    assert robotcore_bridge.next_data(0.06) == encode_request("e")
    robotcore_bridge.reply(noise + b"\n")
    robotcore_bridge.reply(encode_reply("5 5"))
    if noise != b"8 8*10":  # the line was completed, and is valid
        assert robotcore_bridge.angle == 5


@pytest.mark.parametrize("counts", ["99999999999 0", "4294967296 0", "-2147483649 0"])
def test_a_count_beyond_32_bits_is_dropped(robotcore_bridge: ScriptedBoard, counts: str) -> None:
    robotcore_bridge.next_data(0.06)
    robotcore_bridge.reply(encode_reply(counts))
    assert robotcore_bridge.angle == 0


def test_a_board_after_a_short_reset_has_its_time_out_before_it_turns(robotcore_bridge: ScriptedBoard) -> None:
    robotcore_bridge.protocol.limit(0.5)
    robotcore_bridge.exchange((encode_request("k 500"), encode_reply("OK")))
    assert robotcore_bridge.next_data(0.06) == encode_request("e")
    robotcore_bridge.set(20, 20)
    assert robotcore_bridge.next_data(LATE_S) == b"\r" + encode_request("v")
    robotcore_bridge.reply(b"\x00" + encode_reply("robotcore-bridge 1") + encode_reply("robotcore-bridge 1"))
    robotcore_bridge.exchange(
        (encode_request("k 500"), encode_reply("OK")), (encode_request("m 20 20"), encode_reply("OK"))
    )


def test_a_silent_board_is_lost_and_its_command_dropped(robotcore_bridge: ScriptedBoard) -> None:
    robotcore_bridge.set(20, 20)
    assert robotcore_bridge.next_data() == encode_request("m 20 20")
    robotcore_bridge.set(30, 30)
    while robotcore_bridge.protocol.is_ready:
        sent = robotcore_bridge.next_data(0.02)
    assert sent == PROBE
    robotcore_bridge.reply(ROBOTCORE_BRIDGE_REPLY)
    robotcore_bridge.exchange(
        (encode_request("m 0 0"), encode_reply("OK")),
        (encode_request("k 2000"), encode_reply("OK")),
        (encode_request("e"), encode_reply("0 0")),
    )
    assert robotcore_bridge.protocol.is_ready


@pytest.mark.parametrize("has_sonar, within_s", [(False, 0.55), (True, 1.65)])
def test_a_board_whose_replies_are_lost_is_stopped_while_the_app_drives_on(
    ros_arduino_bridge: ScriptedBoard, has_sonar: bool, within_s: float
) -> None:
    board, lost_at = RosArduinoBridgeDouble(), ros_arduino_bridge.now
    if has_sonar:
        ros_arduino_bridge.protocol.poll(ping(7), 0.1, lambda _reply, _now: None)
    while ros_arduino_bridge.now - lost_at < within_s:
        if ros_arduino_bridge.protocol.is_ready:
            ros_arduino_bridge.set(20, 20)
        board.receive(ros_arduino_bridge.next_data(), ros_arduino_bridge.now)
    assert "m 20 20" in board.commands
    assert board.wheels.left.command == board.wheels.right.command == 0


def test_a_missing_board_is_probed_periodically() -> None:
    board = ScriptedBoard()
    assert board.next_data() == PROBE
    assert board.next_data(0.25) == b""
    assert board.next_data(0.06) == PROBE
    board.reply(b"\x00\x80" + ROBOTCORE_BRIDGE_REPLY)
    assert board.protocol.is_ready


def test_motors_by_duty_are_scaled_to_255(robotcore_bridge: ScriptedBoard) -> None:
    robotcore_bridge.protocol.is_duty_mode = True
    robotcore_bridge.set(1.0, -0.25)
    robotcore_bridge.exchange((encode_request("o 255 -64"), encode_reply("OK")))
    robotcore_bridge.set(0, 0)
    robotcore_bridge.exchange((encode_request("m 0 0"), encode_reply("OK")))
