from __future__ import annotations

import pytest

from drivers.serial.boards.sabertooth.protocol import stop
from robotcore.hal.cutoff import merge_cutoffs
from tests.doubles.serial.sabertooth import Sabertooths
from tests.drivers.serial.boards.conftest import OpenRig
from tests.drivers.serial.boards.test_board import sabertooths


def test_motors_of_two_boards_share_a_line(open_rig: OpenRig) -> None:
    line = Sabertooths(addresses=(128, 129))
    rig = open_rig(line, sabertooths(address=129, motor=1))
    rig.drive(4.0, 8.0, 1.0)
    assert line.boards[128].wheels.left.velocity == pytest.approx(4.0, rel=0.02)
    assert line.boards[129].wheels.left.velocity == pytest.approx(8.0, rel=0.02)
    assert [board.timeout_s for board in line.boards.values()] == [0.5, 0.5]
    frames = [spec.parameters["frame"] for spec in merge_cutoffs(rig.robot.cutoffs)]
    assert frames == [stop(128).hex(), stop(129).hex()]
    rig.robot.close()
    assert [board.values for board in line.boards.values()] == [[0, 0]] * 2
    assert line.ignored == 0


def test_a_board_that_received_another_byte_first_ignores_commands(open_rig: OpenRig) -> None:
    line = Sabertooths()
    rig = open_rig(line, sabertooths())
    line.receive(b"\x80", 0.0)
    rig.drive(4.0, 4.0, 0.5)
    assert line.packets == []


def test_a_port_that_is_there_without_a_board_opens(open_rig: OpenRig) -> None:
    open_rig(Sabertooths(addresses=()), sabertooths()).drive(4.0, 4.0, 0.1)
