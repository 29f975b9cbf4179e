"""The protocol of a hoverboard: the times of its frames, and the integration of its speeds."""

from __future__ import annotations

import math

import pytest

from drivers.serial.boards.command import STOP_REPEAT_S
from drivers.serial.boards.hoverboard.board import PAUSE_S, SILENCE_S, HoverboardProtocol
from drivers.serial.boards.hoverboard.protocol import STOP, command
from tests.doubles.serial.hoverboard import RPM, feedback

FRAME_S = 0.01


class Conversation:
    """A protocol with a board that sends feedback every hundredth of a second."""

    def __init__(self) -> None:
        self.protocol = HoverboardProtocol(115200)
        self.protocol.begin(0.0)
        self.now = 0.0
        self.sent: list[tuple[float, bytes]] = []
        self.receive()

    def receive(self, left: float = 0, right: float = 0, steer: int = 0, speed: int = 0, frames: int = 1) -> None:
        """Receive feedback with the wheels' forward speeds in rpm, one frame or several at once."""
        speeds = math.floor(-right), math.floor(left)
        self.protocol.receive(feedback(steer, speed, *speeds, 3700, 300, 0) * frames, self.now)

    def pass_time(self, seconds: float) -> None:
        """Let time pass in thousandths of a second, and take the data to send."""
        for _ in range(round(seconds * 1000)):
            self.now += 0.001
            if frame := self.protocol.data_to_send(self.now):
                self.sent.append((self.now, frame))

    def drive(self, left: float, right: float, seconds: float) -> None:
        for _ in range(round(seconds / FRAME_S)):
            self.pass_time(FRAME_S)
            self.receive(left, right)

    def set(self, left: float, right: float) -> None:
        self.protocol.command.set("left", left, self.now)
        self.protocol.command.set("right", right, self.now)

    def angles(self) -> tuple[float, float]:
        left, right = self.protocol.left.angle(RPM), self.protocol.right.angle(-RPM)
        assert left
        assert right
        return left.angle, right.angle

    @property
    def frames(self) -> list[bytes]:
        return [frame for _, frame in self.sent]


@pytest.fixture
def conversation() -> Conversation:
    return Conversation()


def test_a_stop_is_repeated(conversation: Conversation) -> None:
    conversation.drive(0, 0, 1.0)
    assert set(conversation.frames) == {STOP}
    assert len(conversation.frames) == pytest.approx(1.0 / STOP_REPEAT_S, abs=1)


def test_a_command_that_turns_is_sent_once_so_that_the_boards_own_time_out_counts(conversation: Conversation) -> None:
    conversation.drive(0, 0, 0.05)
    conversation.set(100, 101)
    conversation.drive(100, 100, 1.0)
    assert conversation.frames[1:] == [command(-1, 101)]


def test_frames_are_apart_and_the_newer_command_is_sent(conversation: Conversation) -> None:
    conversation.set(100, 100)
    conversation.pass_time(0.001)
    conversation.set(200, 200)
    conversation.set(300, 300)
    conversation.pass_time(0.02)
    (first_at, _), (second_at, second) = conversation.sent
    assert second_at - first_at >= PAUSE_S - 1e-9
    assert second == command(0, 300)


def test_next_due_is_when_something_is_due(conversation: Conversation) -> None:
    conversation.pass_time(0.001)
    protocol = conversation.protocol
    assert protocol.data_to_send(protocol.next_due(conversation.now) - 1e-6) == b""
    assert protocol.data_to_send(protocol.next_due(conversation.now) + 1e-6) == STOP
    conversation.set(100, 100)
    conversation.drive(100, 100, 0.2)
    assert protocol.next_due(conversation.now) == math.inf


def test_a_stop_is_settled_when_feedback_confirms_it(conversation: Conversation) -> None:
    conversation.set(100, 100)
    conversation.drive(100, 100, 0.02)
    conversation.receive(100, 100)
    conversation.set(0, 0)
    assert not conversation.protocol.is_settled
    conversation.pass_time(0.005)
    assert not conversation.protocol.is_settled, "what it told before it was told to stand says nothing"
    conversation.receive(100, 100, speed=100)
    assert not conversation.protocol.is_settled
    conversation.pass_time(0.01)
    conversation.receive(90, 90)
    assert conversation.protocol.is_settled


def test_a_silent_board_is_lost_and_stands_until_a_new_command(conversation: Conversation) -> None:
    conversation.set(100, 100)
    conversation.drive(100, 100, 0.1)
    conversation.pass_time(SILENCE_S + 0.01)
    assert not conversation.protocol.is_ready
    conversation.sent.clear()
    conversation.drive(0, 0, 0.5)
    assert conversation.protocol.is_ready
    assert set(conversation.frames) == {STOP}


def test_angles_are_the_measured_speeds_over_their_times(conversation: Conversation) -> None:
    conversation.drive(60.5, -30.5, 1.0)
    assert conversation.angles() == pytest.approx((60.5 * RPM, -30.5 * RPM), rel=0.01)


def test_frames_that_come_at_once_count_as_long_as_they_took(conversation: Conversation) -> None:
    conversation.receive(60.5, 60.5)
    for _ in range(10):
        conversation.pass_time(0.02)
        conversation.receive(60.5, 60.5, frames=2)
    assert conversation.angles() == pytest.approx((0.2 * 60.5 * RPM,) * 2)


def test_frames_that_waited_in_the_buffer_are_no_gap(conversation: Conversation) -> None:
    conversation.receive(60.5, 60.5)
    conversation.now += 1.0
    conversation.receive(60.5, 60.5, frames=100)
    assert conversation.angles() == pytest.approx((60.5 * RPM,) * 2)


def test_nothing_is_added_for_a_time_without_feedback(conversation: Conversation) -> None:
    conversation.drive(60.5, 60.5, 1.0)
    before = conversation.angles()
    conversation.pass_time(SILENCE_S + 0.01)
    conversation.receive(60.5, 60.5)
    assert conversation.angles() == before
    conversation.drive(60.5, 60.5, 0.5)
    assert conversation.angles()[0] - before[0] == pytest.approx(0.5 * 60.5 * RPM)


def test_a_port_that_comes_back_goes_on_from_the_last_angle(conversation: Conversation) -> None:
    conversation.drive(60.5, 60.5, 1.0)
    before = conversation.angles()
    conversation.now += 0.1
    conversation.protocol.begin(conversation.now)
    assert not conversation.protocol.is_ready
    conversation.now += 0.1
    conversation.receive(60.5, 60.5)
    assert conversation.angles() == before


def test_voltage_is_the_newest_one(conversation: Conversation) -> None:
    conversation.now = 0.5
    conversation.receive()
    voltage = conversation.protocol.voltage
    assert voltage
    assert (voltage.voltage, voltage.time, voltage.sequence) == (37.0, 0.5, 1)
