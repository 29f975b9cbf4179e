from __future__ import annotations

import re
from functools import reduce
from operator import xor

from hypothesis import given
from hypothesis import strategies as st

from tests.firmware.host import Command, Firmware

_TAKEN = re.compile(rb"([ -~])((?: -?[0-9]{1,6}(?:[ :]-?[0-9]{1,6}){0,3})?)(?:\*[0-9A-F]{2})?")


def add_checksum(line: str) -> bytes:
    return f"{line}*{reduce(xor, line.encode()):02X}\r".encode()


def test_command_is_parsed(firmware: Firmware) -> None:
    for line, command in [
        (b"e\r", Command("e", ())),
        (b"m 20 -20\r", Command("m", (20, -20))),
        (b"o -255 255\r", Command("o", (-255, 255))),
        (b"u 20:12:0:50\r", Command("u", (20, 12, 0, 50))),
        (b"k 32767\r", Command("k", (32767,))),
        (b"m -0 00007\r", Command("m", (0, 7))),
        (add_checksum("m 20 20"), Command("m", (20, 20), has_checksum=True)),
        (add_checksum("v"), Command("v", (), has_checksum=True)),
    ]:
        assert firmware.parse(line) == [command], line


MALFORMED = (
    b" e", b"ee", b"m ", b"m 20 ", b"m  20 20", b"m20 20", b"m 20,20", b"m 20:20", b"m 2O 20", b"m - 20",
    b"m +5 5", b"m --5 5", b"m 1.5 2", b"u 20 12 0 50", b"u 20:12:0:50:1", b"m 1 2 3 4 5",
    b"k 32768", b"k 99999", b"k 100000", b"k 65636", b"k 4294967396", b"m 20\x0020", b"m 2\n0 20", b"m 20 2\xb0",
    b"m 20 20*", b"m 20 20*6", b"m 20 20*6d", b"m 20 20*6E", b"m 20 20*6D ", b"\x1b[A",
    b"m 20 20 " + 30 * b"0", 1000 * b"m",
)  # fmt: skip


def test_malformed_line_is_no_command_and_the_next_line_is_parsed(firmware: Firmware) -> None:
    for line in MALFORMED:
        assert firmware.parse(line + b"\re\r") == [None, Command("e", ())], line


def test_line_of_31_characters_is_read_and_of_32_dropped(firmware: Firmware) -> None:
    longest, longer = b"u -000020:-000012:000000:000050\r", b"u -000020:-000012:-000000:000050\r"
    assert (len(longest), len(longer)) == (32, 33)
    assert firmware.parse(longest + longer + b"e\r") == [Command("u", (-20, -12, 0, 50)), None, Command("e", ())]


def test_empty_line_is_ignored(firmware: Firmware) -> None:
    for nothing in [b"\r", b"\r\r\r", b"\r\n", b"\n\r", b"\n\n"]:
        assert firmware.parse(nothing + b"e\r") == [Command("e", ())], nothing


def test_lines_that_end_in_cr_lf_are_parsed(firmware: Firmware) -> None:
    assert firmware.parse(b"e\r\nm 5 5\r\n") == [Command("e", ()), Command("m", (5, 5))]


@given(data=st.binary(max_size=200))
def test_random_bytes_give_only_commands_that_they_hold(firmware: Firmware, data: bytes) -> None:
    lines = [line for line in (part.lstrip(b"\n") for part in data.split(b"\r")[:-1]) if line]
    commands = firmware.parse(data)
    assert len(commands) == len(lines)
    for line, command in zip(lines, commands, strict=True):
        assert command is None or (_TAKEN.fullmatch(line) and command.name == chr(line[0]))


_numbers = st.integers(-32767, 32767)


@given(left=_numbers, right=_numbers, position=st.integers(0, 30), mask=st.integers(1, 255))
def test_checksum_detects_every_single_damaged_byte(
    firmware: Firmware, left: int, right: int, position: int, mask: int
) -> None:
    line = bytearray(add_checksum(f"m {left} {right}"))
    line[position % len(line)] ^= mask
    for command in firmware.parse(bytes(line)):
        assert command is None or not command.has_checksum
