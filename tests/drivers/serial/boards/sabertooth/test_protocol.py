"""Packets as Dimension Engineering's manuals and Arduino library make them."""

from __future__ import annotations

import pytest

from drivers.serial.boards.sabertooth.protocol import drive, packet, stop, timeout

PACKETS = {
    "manual, figure 7.1: half speed forward": (packet(130, 0, 64), [130, 0, 64, 66]),
    "motor 1 forward": (drive(128, 1, 1.0), [128, 0, 127, 127]),
    "motor 1 backward": (drive(128, 1, -0.5), [128, 1, 64, 65]),
    "motor 2 forward": (drive(135, 2, 0.25), [135, 4, 32, 43]),
    "motor 2 backward": (drive(135, 2, -1.0), [135, 5, 127, 11]),
    "less than a step": (drive(128, 2, -0.001), [128, 4, 0, 4]),
    "both stand": (stop(129), [129, 0, 0, 1, 129, 4, 0, 5]),
    "half a second": (timeout(128, 0.5), [128, 14, 5, 19]),
    "whole tenths, no earlier than asked": (timeout(128, 0.41), [128, 14, 5, 19]),
    "at least a tenth: 0 would switch it off": (timeout(128, 0.0), [128, 14, 1, 15]),
    "at most 12.7 s": (timeout(128, 60.0), [128, 14, 127, 13]),
}


@pytest.mark.parametrize("what", PACKETS)
def test_packets_are_as_the_board_takes_them(what: str) -> None:
    made, expected = PACKETS[what]
    assert list(made) == expected
