"""Packets of Dimension Engineering's manuals and Arduino library."""

from __future__ import annotations

import math

import pytest

from drivers.serial.boards.sabertooth.protocol import (
    BAUD_DETECTION,
    SETTLING_S,
    SabertoothProtocol,
    build_drive_packet,
    build_packet,
    build_stop_packets,
    build_timeout_packet,
)
from robotcore.hal.cutoff import merge_cutoffs
from tests.doubles.serial.sabertooth import Sabertooths
from tests.drivers.serial.boards.conftest import OpenRig
from tests.drivers.serial.boards.test_board import sabertooths
from tests.texts import CheckText

PACKETS = {
    "manual, figure 7.1: half speed forward": (build_packet(130, 0, 64), [130, 0, 64, 66]),
    "motor 1 forward": (build_drive_packet(128, 1, 1.0), [128, 0, 127, 127]),
    "motor 1 backward": (build_drive_packet(128, 1, -0.5), [128, 1, 64, 65]),
    "motor 2 forward": (build_drive_packet(135, 2, 0.25), [135, 4, 32, 43]),
    "motor 2 backward": (build_drive_packet(135, 2, -1.0), [135, 5, 127, 11]),
    "less than a step": (build_drive_packet(128, 2, -0.001), [128, 4, 0, 4]),
    "both stand": (build_stop_packets(129), [129, 0, 0, 1, 129, 4, 0, 5]),
    "half a second": (build_timeout_packet(128, 0.5), [128, 14, 5, 19]),
    "whole tenths, no earlier than asked": (build_timeout_packet(128, 0.41), [128, 14, 5, 19]),
    "at least a tenth: 0 would switch it off": (build_timeout_packet(128, 0.0), [128, 14, 1, 15]),
    "at most 12.7 s": (build_timeout_packet(128, 60.0), [128, 14, 127, 13]),
}


def test_packets_equal_those_of_the_manuals() -> None:
    for what, (made, expected) in PACKETS.items():
        assert list(made) == expected, what


STANDING = build_stop_packets(128) + build_timeout_packet(128, 0.5)


@pytest.fixture
def protocol() -> SabertoothProtocol:
    protocol = SabertoothProtocol(9600)
    protocol.board(128, 0.5)
    protocol.begin(0.0)
    return protocol


def begin(protocol: SabertoothProtocol) -> SabertoothProtocol:
    """Let the protocol send the byte for the baud rate and the first stops."""
    assert [protocol.data_to_send(0.0), protocol.data_to_send(SETTLING_S)] == [BAUD_DETECTION, STANDING]
    return protocol


def test_the_baud_rate_goes_first_and_is_given_time(protocol: SabertoothProtocol) -> None:
    assert protocol.next_due(0.0) == 0.0
    assert protocol.data_to_send(0.0) == BAUD_DETECTION
    assert protocol.data_to_send(SETTLING_S - 0.01) == b""
    assert not protocol.is_ready
    assert protocol.next_due(0.1) == SETTLING_S
    assert protocol.data_to_send(SETTLING_S) == STANDING
    assert protocol.is_ready


def test_a_command_that_turns_is_sent_once_with_the_boards_time_out(protocol: SabertoothProtocol) -> None:
    command = begin(protocol).board(128, 0.5).command
    command.set("left", 1.0, 1.0)
    assert not protocol.is_settled
    command.set("right", -0.5, 1.0)
    motors = build_drive_packet(128, 1, 1.0) + build_drive_packet(128, 2, -0.5)
    assert protocol.data_to_send(1.0) == motors + build_timeout_packet(128, 0.5)
    assert protocol.is_settled
    assert protocol.data_to_send(5.0) == b""
    assert protocol.next_due(5.0) == math.inf


def test_the_shortest_time_out_of_both_motors_applies(protocol: SabertoothProtocol, check_text: CheckText) -> None:
    protocol.board(128, 0.11)
    protocol.board(128, 1.0)
    protocol.data_to_send(0.0)
    assert protocol.data_to_send(SETTLING_S) == build_stop_packets(128) + build_timeout_packet(128, 0.2)
    check_text(protocol.timeout_notice)


def test_boards_on_one_line_have_their_own_commands_and_stops_go_first(protocol: SabertoothProtocol) -> None:
    protocol.board(135, 1.0)
    protocol.data_to_send(0.0)
    assert protocol.data_to_send(SETTLING_S) == STANDING + build_stop_packets(135) + build_timeout_packet(135, 1.0)
    for address, duty in ((128, 0.5), (135, 0.0)):
        for side in ("left", "right"):
            protocol.board(address, 1.0).command.set(side, duty, 1.0)
    assert protocol.data_to_send(1.0) == build_stop_packets(135) + build_timeout_packet(135, 1.0)
    assert protocol.data_to_send(1.01)[:4] == build_drive_packet(128, 1, 0.5)


def test_while_one_board_turns_no_other_is_repeated(protocol: SabertoothProtocol) -> None:
    protocol.board(135, 1.0)
    begun_at = SETTLING_S
    protocol.data_to_send(0.0)
    protocol.data_to_send(begun_at)
    protocol.board(128, 0.5).command.set("left", 0.5, 1.0)
    assert protocol.data_to_send(1.1)
    assert protocol.data_to_send(9.0) == b""


def test_a_command_from_before_a_loss_is_dropped(protocol: SabertoothProtocol) -> None:
    begin(protocol).board(128, 0.5).command.set("left", 1.0, 1.0)
    protocol.begin(2.0)
    assert not protocol.is_ready
    assert [protocol.data_to_send(2.0), protocol.data_to_send(2.0 + SETTLING_S)] == [BAUD_DETECTION, STANDING]


def test_motors_of_two_boards_share_a_line(open_rig: OpenRig) -> None:
    line = Sabertooths(addresses=(128, 129))
    rig = open_rig(line, sabertooths(address=129, motor=1))
    rig.drive(4.0, 8.0, 1.0)
    assert line.boards[128].wheels.left.velocity == pytest.approx(4.0, rel=0.02)
    assert line.boards[129].wheels.left.velocity == pytest.approx(8.0, rel=0.02)
    assert [board.timeout_s for board in line.boards.values()] == [0.5, 0.5]
    frames = [spec.parameters["frame"] for spec in merge_cutoffs(rig.robot.cutoffs)]
    assert frames == [build_stop_packets(128).hex(), build_stop_packets(129).hex()]
    rig.robot.close()
    assert [board.values for board in line.boards.values()] == [[0, 0]] * 2
    assert line.ignored == 0
