"""The protocol of an Arduino, with the test as the board."""

from __future__ import annotations

import pytest

from drivers.serial.boards.rosarduino.board import ArduinoProtocol
from drivers.serial.boards.rosarduino.protocol import build_ping_request, frame_line
from tests.doubles.serial.rosarduino import RosArduinoBridgeDouble
from tests.texts import CheckText

BAUD = 57600
STEP_S = 0.002

PROBE = b"\rm 0 0\rv*76\rb\r"
ROBOTCORE_BRIDGE_REPLY = b"OK\r\nrobotcore-bridge 1*5C\r\n57600\r\n"
ROS_ARDUINO_BRIDGE_REPLY = b"Invalid Command\r\nOK\r\nInvalid Command\r\n57600\r\n"


def encode_request(text: str) -> bytes:
    return frame_line(text, is_summed=True)


def encode_reply(text: str) -> bytes:
    return frame_line(text, is_summed=True) + b"\n"


class ScriptedBoard:
    """A protocol, with the test as the board. ``now`` advances by `STEP_S` with each exchange."""

    def __init__(self) -> None:
        self.protocol = ArduinoProtocol(BAUD)
        self.now = 10.0
        self.protocol.begin(self.now)

    def next_data(self, after: float = STEP_S) -> bytes:
        """Return the data that the protocol sends ``after`` seconds from now."""
        self.now += after
        return self.protocol.data_to_send(self.now)

    def reply(self, data: bytes) -> None:
        self.now += STEP_S
        self.protocol.receive(data, self.now)

    def exchange(self, *turns: tuple[bytes, bytes]) -> None:
        """Expect requests one after another, and reply to each.

        turns: the expected request and the reply, several times.
        """
        for sent, received in turns:
            assert self.next_data() == sent
            self.reply(received)

    def accept(self, *texts: str) -> None:
        """Expect requests with checksums one after another, and accept each."""
        self.exchange(*((encode_request(text), encode_reply("OK")) for text in texts))

    def identify_robotcore_bridge(self) -> None:
        """Exchange frames until robotcore_bridge is identified, and the protocol only polls counts."""
        self.exchange((PROBE, ROBOTCORE_BRIDGE_REPLY))
        self.accept("m 0 0", "k 2000")
        self.exchange((encode_request("e"), encode_reply("0 0")))

    def identify_ros_arduino_bridge(self) -> None:
        self.exchange(
            (PROBE, ROS_ARDUINO_BRIDGE_REPLY),
            (PROBE, ROS_ARDUINO_BRIDGE_REPLY),
            (b"m 0 0\r", b"OK\r\n"),
            (b"o 0 0\r", b"Invalid Command\r\n"),
            (b"o 0 0\r", b"Invalid Command\r\n"),
            (b"m 0 0\r", b"OK\r\n"),
            (b"e\r", b"0 0\r\n"),
        )

    def set(self, left: float, right: float) -> None:
        """Set the commands of both motors in one tick."""
        self.protocol.command.set("left", left, self.now)
        self.protocol.command.set("right", right, self.now)

    @property
    def angle(self) -> float:
        """The angle of the left wheel in counts."""
        sample = self.protocol.counters["left"].angle(1.0)
        assert sample
        return sample.angle


LATE_S = 0.11
"""A time after which a request without a reply times out, in seconds."""


@pytest.fixture
def bridge() -> ScriptedBoard:
    board = ScriptedBoard()
    board.identify_robotcore_bridge()
    return board


@pytest.fixture
def ros_arduino_bridge() -> ScriptedBoard:
    board = ScriptedBoard()
    board.identify_ros_arduino_bridge()
    return board


def test_robotcore_bridge_is_identified_by_its_name(bridge: ScriptedBoard) -> None:
    assert bridge.protocol.is_ready
    assert bridge.protocol.firmware.is_robotcore_bridge
    assert bridge.protocol.firmware.control_period_s == pytest.approx(1 / 30)


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
    ros_arduino_bridge.exchange((PROBE, ROBOTCORE_BRIDGE_REPLY))
    ros_arduino_bridge.accept("m 0 0", "k 2000")
    ros_arduino_bridge.set(20, 20)
    ros_arduino_bridge.accept("m 20 20")


def test_the_time_out_is_sent_before_a_motor_turns(bridge: ScriptedBoard, check_text: CheckText) -> None:
    bridge.protocol.limit(0.5)
    bridge.set(20, 20)
    bridge.accept("k 500", "m 20 20")
    check_text(bridge.protocol.timeout_notice)


def test_only_the_newest_command_is_sent_and_only_once(bridge: ScriptedBoard) -> None:
    assert bridge.next_data(0.06) == encode_request("e")
    bridge.set(10, 10)
    bridge.set(20, -20)
    assert bridge.next_data() == b""
    bridge.reply(encode_reply("0 0"))
    bridge.accept("m 20 -20")
    assert bridge.next_data() == b""
    bridge.set(20, -20)
    bridge.accept("m 20 -20")


@pytest.mark.parametrize("left, right", [(20, 20), (0, 20)])
def test_a_turning_command_without_acknowledgement_is_not_repeated(
    bridge: ScriptedBoard, left: int, right: int
) -> None:
    bridge.set(left, right)
    assert bridge.next_data() == encode_request(f"m {left} {right}")
    assert bridge.next_data(LATE_S) == b"\r" + encode_request("v")
    bridge.reply(encode_reply("robotcore-bridge 1"))
    bridge.exchange((encode_request("k 2000"), encode_reply("OK")), (encode_request("e"), encode_reply("0 0")))
    assert not bridge.protocol.is_settled


def test_a_stop_is_repeated_until_it_is_acknowledged(bridge: ScriptedBoard) -> None:
    bridge.set(20, 20)
    bridge.accept("m 20 20")
    bridge.set(0, 0)
    assert not bridge.protocol.is_settled
    stop = encode_request("m 0 0")
    bridge.exchange((stop, encode_reply("Invalid Command")))
    assert not bridge.protocol.is_settled
    bridge.exchange((stop, encode_reply("OK")))
    assert bridge.protocol.is_settled


def test_a_stop_does_not_wait_for_a_slow_reply(bridge: ScriptedBoard) -> None:
    assert bridge.next_data(0.06) == encode_request("e")
    bridge.set(0, 0)
    assert bridge.next_data() == b""
    assert bridge.next_data(0.02) == b"\rm 0 0\r"
    bridge.reply(encode_reply("7 7") + b"OK\r\n")
    bridge.exchange((b"\r" + encode_request("v"), encode_reply("robotcore-bridge 1")))
    bridge.accept("m 0 0", "k 2000")


def test_a_late_reply_is_not_taken_for_the_next_reply(ros_arduino_bridge: ScriptedBoard) -> None:
    assert ros_arduino_bridge.next_data(0.06) == b"e\r"
    assert ros_arduino_bridge.next_data(LATE_S) == b"\rb\r"
    ros_arduino_bridge.reply(b"500 500\r\nInvalid Command\r\n")
    assert ros_arduino_bridge.next_data() == b""
    ros_arduino_bridge.reply(b"57600\r\n")
    ros_arduino_bridge.exchange((b"e\r", b"3 3\r\n"))
    assert ros_arduino_bridge.angle == 3


def test_the_wait_for_a_reply_is_longer_after_a_late_reply(bridge: ScriptedBoard) -> None:
    assert bridge.next_data(0.06) == encode_request("e")
    assert bridge.next_data(LATE_S) == b"\r" + encode_request("v")
    bridge.reply(encode_reply("1 0") + encode_reply("robotcore-bridge 1"))
    bridge.exchange((encode_request("k 2000"), b""))
    assert bridge.next_data(2 * LATE_S) == b""
    bridge.reply(encode_reply("OK"))
    assert bridge.next_data() == encode_request("e")
    assert bridge.next_data(2 * LATE_S) == b""
    bridge.reply(encode_reply("7 0"))
    assert bridge.angle == 7
    assert bridge.next_data() == encode_request("e")
    bridge.reply(encode_reply("8 0"))
    assert bridge.next_data(0.06) == encode_request("e")
    assert bridge.next_data(LATE_S) == b"\r" + encode_request("v")


@pytest.mark.parametrize(
    "noise",
    [
        encode_reply("4294967296 0"),
        encode_reply("-2147483649 0"),
        b"8 8*00\r\n",
        b"8 8\r\n",
        b"OK*04\r\n",
        b"\xff8 8*10\r\n",
        b"\n\n\r\n",
        b"9" * 100 + b" 8*10\r\n",
        b"8 8*10",
    ],
    ids=["too large", "too small", "wrong sum", "no sum", "other shape", "no letter", "empty", "too long", "cut"],
)
def test_a_line_that_is_no_reply_is_dropped(bridge: ScriptedBoard, noise: bytes) -> None:
    assert bridge.next_data(0.06) == encode_request("e")
    bridge.reply(noise + b"\n")
    bridge.reply(encode_reply("5 5"))
    if noise != b"8 8*10":  # the line was completed, and is valid
        assert bridge.angle == 5


def test_a_board_after_a_short_reset_has_its_time_out_before_it_turns(bridge: ScriptedBoard) -> None:
    bridge.protocol.limit(0.5)
    bridge.accept("k 500")
    assert bridge.next_data(0.06) == encode_request("e")
    bridge.set(20, 20)
    assert bridge.next_data(LATE_S) == b"\r" + encode_request("v")
    bridge.reply(b"\x00" + encode_reply("robotcore-bridge 1") + encode_reply("robotcore-bridge 1"))
    bridge.accept("k 500", "m 20 20")


@pytest.mark.parametrize("has_sonar, within_s", [(False, 0.55), (True, 1.65)])
def test_a_board_whose_replies_are_lost_is_stopped_while_the_app_drives_on(
    ros_arduino_bridge: ScriptedBoard, has_sonar: bool, within_s: float
) -> None:
    board, lost_at = RosArduinoBridgeDouble(), ros_arduino_bridge.now
    if has_sonar:
        ros_arduino_bridge.protocol.poll(build_ping_request(7), 0.1, lambda _reply, _now: None)
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


def test_motors_by_duty_are_scaled_to_255(bridge: ScriptedBoard) -> None:
    bridge.protocol.is_duty_mode = True
    bridge.set(1.0, -0.25)
    bridge.accept("o 255 -64")
    bridge.set(0, 0)
    bridge.accept("m 0 0")
