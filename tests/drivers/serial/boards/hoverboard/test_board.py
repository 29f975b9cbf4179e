"""A hoverboard: the times of its frames, the integration of its speeds, and the modes of its firmware."""

from __future__ import annotations

import math
from typing import Any

import pytest

from drivers.serial.boards.hoverboard.protocol import PAUSE_S, SILENCE_S, STOP, HoverboardProtocol, build_command
from robotcore.errors import DeviceLostError
from tests.doubles.serial.bench import Rig, board_devices
from tests.doubles.serial.hoverboard import RPM, Hoverboard, feedback
from tests.drivers.serial.boards.conftest import OpenRig

FRAME_S = 0.01


class ScriptedBoard:
    """A protocol, with the test as a board that sends feedback every 10 ms."""

    def __init__(self) -> None:
        self.protocol = HoverboardProtocol(115200)
        self.protocol.begin(0.0)
        self.now = 0.0
        self.sent: list[tuple[float, bytes]] = []
        self.receive()

    def receive(self, left: float = 0, right: float = 0, steer: int = 0, speed: int = 0, frames: int = 1) -> None:
        """Give the protocol feedback, ``frames`` frames at once. ``left`` and ``right`` are forward speeds in rpm."""
        speeds = math.floor(-right), math.floor(left)
        self.protocol.receive(feedback(steer, speed, *speeds, 3700, 300, 0) * frames, self.now)

    def pass_time(self, seconds: float) -> None:
        """Let time pass in steps of 1 ms, and record the data to send."""
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
        left, right = self.protocol.counters["left"].angle(RPM), self.protocol.counters["right"].angle(-RPM)
        assert left
        assert right
        return left.angle, right.angle

    @property
    def frames(self) -> list[bytes]:
        return [frame for _, frame in self.sent]


@pytest.fixture
def board() -> ScriptedBoard:
    return ScriptedBoard()


def test_frames_have_a_pause_in_between_and_the_newest_command_is_sent(board: ScriptedBoard) -> None:
    board.set(100, 100)
    board.pass_time(0.001)
    board.set(200, 200)
    board.set(300, 300)
    board.pass_time(0.02)
    (first_at, _), (second_at, second) = board.sent
    assert second_at - first_at >= PAUSE_S - 1e-9
    assert second == build_command(0, 300)


def test_next_due_is_the_time_of_the_next_frame(board: ScriptedBoard) -> None:
    board.pass_time(0.001)
    protocol = board.protocol
    assert protocol.data_to_send(protocol.next_due(board.now) - 1e-6) == b""
    assert protocol.data_to_send(protocol.next_due(board.now) + 1e-6) == STOP
    board.set(100, 100)
    board.drive(100, 100, 0.2)
    assert protocol.next_due(board.now) == math.inf


def test_a_stop_is_settled_when_feedback_confirms_it(board: ScriptedBoard) -> None:
    board.set(100, 100)
    board.drive(100, 100, 0.02)
    board.receive(100, 100)
    board.set(0, 0)
    assert not board.protocol.is_settled
    board.pass_time(0.005)
    assert not board.protocol.is_settled, "feedback from before the command to stand proves nothing"
    board.receive(100, 100, speed=100)
    assert not board.protocol.is_settled
    board.pass_time(0.01)
    board.receive(90, 90)
    assert board.protocol.is_settled


def test_angles_are_the_measured_speeds_over_their_times(board: ScriptedBoard) -> None:
    board.drive(60.5, -30.5, 1.0)
    assert board.angles() == pytest.approx((60.5 * RPM, -30.5 * RPM), rel=0.01)


def test_frames_that_arrive_at_once_are_integrated_over_their_time(board: ScriptedBoard) -> None:
    board.receive(60.5, 60.5)
    for _ in range(10):
        board.pass_time(0.02)
        board.receive(60.5, 60.5, frames=2)
    assert board.angles() == pytest.approx((0.2 * 60.5 * RPM,) * 2)


def test_a_time_without_feedback_is_not_integrated(board: ScriptedBoard) -> None:
    board.drive(60.5, 60.5, 1.0)
    before = board.angles()
    board.pass_time(SILENCE_S + 0.01)
    board.receive(60.5, 60.5)
    assert board.angles() == before
    board.drive(60.5, 60.5, 0.5)
    assert board.angles()[0] - before[0] == pytest.approx(0.5 * 60.5 * RPM)


FULL_RAD_S = 40.0
MODEL = {"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}


def open_hoverboard(open_rig: OpenRig, board: Hoverboard, **motor: Any) -> Rig:
    return open_rig(board, board_devices("hoverboard", motor))


def test_a_board_built_for_another_rpm_turns_at_the_command(open_rig: OpenRig) -> None:
    board = Hoverboard(0.5 * RPM)
    open_hoverboard(open_rig, board, mode="speed", max_rpm=500).drive(4.0, 4.0, 1.0)
    assert board.wheels.left.velocity == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("motor", [{"mode": "speed"}, {"mode": "duty", "model": MODEL}], ids=["speed", "duty"])
def test_an_inverted_motor_turns_the_other_way(open_rig: OpenRig, motor: dict[str, Any]) -> None:
    board = Hoverboard()
    open_hoverboard(open_rig, board, **motor, inverted=True).drive(4.0, 4.0, 0.5)
    assert board.wheels.left.velocity < 0 > board.wheels.right.velocity


def test_a_wheel_with_a_wrong_model_is_controlled_by_the_measured_speed(open_rig: OpenRig) -> None:
    board = Hoverboard(FULL_RAD_S / 1500, is_tank=True)
    open_hoverboard(open_rig, board, mode="duty", model=MODEL, tank_steering=True, control={}).drive(8.0, 4.0, 2.0)
    assert (board.wheels.left.velocity, board.wheels.right.velocity) == pytest.approx((8.0, 4.0), rel=0.05)
    assert board.ignored == 0


def test_a_silent_board_gets_stops_and_turns_again_after_its_silence(open_rig: OpenRig) -> None:
    board = Hoverboard()
    rig = open_hoverboard(open_rig, board, mode="speed")
    rig.drive(4.0, 4.0, 0.5)
    board.is_mute = True
    with pytest.raises(DeviceLostError):
        rig.drive(4.0, 4.0, 1.0)
    board.is_mute = False
    rig.pass_time(0.2)
    assert board.received[-1] == (0, 0)
    rig.drive(4.0, 4.0, 0.5)
