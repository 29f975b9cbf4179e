"""The odometry of a robot with encoders on a board, whose counts arrive between two ticks."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import pytest

from robotcore.geometry import Wheels
from robotcore.hal.drive import Odometry, WheelPath
from robotcore.runtime.layers import assemble
from tests.doubles.serial.bench import Devices, Rig, board_devices
from tests.doubles.serial.board import PERIOD_S, BoardDouble
from tests.doubles.serial.hoverboard import Hoverboard
from tests.doubles.serial.rosarduino import RobotcoreBridgeDouble
from tests.doubles.serial.waveshare import WaveshareBoard
from tests.drivers.serial.boards.conftest import OpenRig

TICK_S, TICKS = 0.1, 20
BOARDS: dict[str, tuple[Callable[[], BoardDouble], Devices]] = {
    "robotcore_bridge": (lambda: RobotcoreBridgeDouble(counts_per_turn=3840), board_devices("ros-arduino")),
    "hoverboard": (Hoverboard, board_devices("hoverboard", {"mode": "speed"})),
    "waveshare": (lambda: WaveshareBoard(0.065), board_devices("waveshare")),
}
"""A double of each board, and the devices on it."""


class Weaving(NamedTuple):
    """A drive to alternating sides."""

    error: float
    """The distance between the pose by odometry and the true pose at the end, in metres."""
    received: int
    """The number of bytes that the board received."""


def weave(rig: Rig, encoder_rate_hz: float | None) -> Weaving:
    board, received = rig.powered.board, list[bytes]()
    receive = board.receive

    def receive_counted(data: bytes, now: float) -> bytes:
        received.append(data)
        return receive(data, now)

    board.receive = receive_counted  # type: ignore[method-assign]
    robot = assemble(rig.robot, rig.description, 1 / TICK_S, encoder_rate_hz=encoder_rate_hz)
    drive, wheels = robot.robot.drive, board.wheels
    true = Odometry(drive.geometry, lambda: WheelPath(Wheels(wheels.left.angle, wheels.right.angle)))
    rig.clock.call_every(PERIOD_S, true.pose, "truth")
    for tick in range(TICKS):
        drive.track()
        drive.set_wheels(*[(10.0, 2.0), (2.0, 10.0)][tick // 3 % 2])
        assert robot.command_filter
        robot.command_filter.commit()
        robot.clock.sleep_until(robot.clock.now() + TICK_S)
    pose, end = drive.pose, true.latest
    return Weaving(pose.distance_to(end.x, end.y), sum(map(len, received)))


@pytest.mark.slow
@pytest.mark.parametrize("board", BOARDS)
def test_polls_send_nothing_to_a_board_and_fast_counts_make_the_pose_exact(board: str, open_rig: OpenRig) -> None:
    build, devices = BOARDS[board]
    runs = []
    for encoder_rate_hz in (200.0, None):
        rig = open_rig(build(), devices)
        runs.append(weave(rig, encoder_rate_hz))
        rig.close()
    polled, without = runs
    assert polled.received == without.received
    if board == "robotcore_bridge":  # it sends counts about 200 times in a second
        assert polled.error < without.error / 10
