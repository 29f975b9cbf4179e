"""Frames as the firmware's own structs have them, compiled from its source and written out once."""

from __future__ import annotations

import pytest

from drivers.serial.boards.hoverboard.protocol import Feedback, Parser, command

COMMANDS = {
    (0, 0): "cdab00000000cdab",
    (100, -200): "cdab640038ff9154",
    (-1, 1): "cdabffff01003354",
}

STANDING = bytes.fromhex("cdab00000000d8ff2800d40e2c010000c55b")
TURNING = bytes.fromhex("cdab640038fffa00ceffac0ff1ff0300fb5b")
FEEDBACK = {
    STANDING: Feedback(0, 0, -40, 40, 37.96, 30.0),
    TURNING: Feedback(100, -200, 250, -50, 40.12, -1.5),
}


@pytest.mark.parametrize("words", COMMANDS)
def test_commands_are_what_the_firmware_takes(words: tuple[int, int]) -> None:
    assert command(*words).hex() == COMMANDS[words]


@pytest.mark.parametrize("frame", FEEDBACK)
def test_feedback_is_what_the_firmware_says(frame: bytes) -> None:
    assert Parser().feed(frame) == [FEEDBACK[frame]]


@pytest.mark.parametrize("at", range(18))
def test_a_frame_with_a_broken_byte_is_dropped_and_the_next_is_found(at: int) -> None:
    broken = bytearray(STANDING)
    broken[at] ^= 0x10
    assert Parser().feed(bytes(broken) + TURNING) == [FEEDBACK[TURNING]]


@pytest.mark.parametrize("kept", range(1, 18))
def test_a_frame_that_was_cut_costs_no_other(kept: int) -> None:
    parser = Parser()
    assert parser.feed(STANDING[:kept] + TURNING + STANDING) == [FEEDBACK[TURNING], FEEDBACK[STANDING]]


@pytest.mark.parametrize(
    "words",
    [(1600, 0, 0, 0, 3700, 300, 0), (0, 0, 0, -2100, 3700, 300, 0), (0, 0, 0, 0, -1, 300, 0), (0, 0, 0, 0, 0, 0, 256)],
    ids=["input", "speed", "voltage", "lamps"],
)
def test_what_no_board_says_is_dropped_though_its_checksum_is_right(words: tuple[int, ...]) -> None:
    from tests.doubles.serial.hoverboard import feedback

    parser = Parser()
    assert parser.feed(feedback(*words)) == []
    assert parser.dropped == 1
