from __future__ import annotations

from itertools import product

import pytest

from drivers.serial.boards.rosarduino.protocol import (
    BATTERY,
    COUNTS,
    STOP,
    Reply,
    build_deadman_request,
    build_identity_request,
    build_ping_request,
    build_presence_request,
    build_speed_request,
    frame_line,
    remove_sum,
)

REFUSED = "Invalid Command"


def test_a_reply_is_matched_by_its_pattern() -> None:
    for entry, sent, line, reply in [
        (COUNTS, b"e\r", "118 -120", Reply((118, -120))),
        (COUNTS, b"e\r", "118", None),
        (COUNTS, b"e\r", "118 ", None),
        (COUNTS, b"e\r", "OK", None),
        (COUNTS, b"e\r", REFUSED, Reply(is_refusal=True)),
        (build_speed_request(20, -3), b"m 20 -3\r", "OK", Reply()),
        (STOP, b"m 0 0\r", "0 0", None),
        (BATTERY, b"y\r", "-1", Reply((-1,))),
        (build_deadman_request(500), b"k 500\r", "OK", Reply()),
        (build_ping_request(7), b"p 7\r", "52", Reply((52,))),
        (build_ping_request(7), b"p 7\r", "57600", None),
        (build_ping_request(7), b"p 7\r", "-1", None),
        (build_identity_request(57600), b"\rm 0 0\rv*76\rb\r", "57600", Reply((57600,))),
        (build_identity_request(57600), b"\rm 0 0\rv*76\rb\r", "robotcore-bridge 1", Reply((1,))),
        (build_identity_request(57600), b"\rm 0 0\rv*76\rb\r", REFUSED, None),
        (build_presence_request(57600, 1.0, is_summed=False), b"\rb\r", "5760", None),
        (build_presence_request(57600, 1.0, is_summed=True), b"\rv*76\r", "57600", None),
    ]:
        assert entry.frame(is_summed=False) == sent
        assert entry.parse_reply(line) == reply, (sent, line)


@pytest.mark.parametrize("text", ["e", "m 20 -20", "118 -120", "OK"])
def test_the_checksum_detects_one_wrong_byte(text: str) -> None:
    line = frame_line(text, is_summed=True).removesuffix(b"\r")
    assert remove_sum(line.decode()) == text
    for place, change in product(range(len(line)), range(1, 128)):
        spoilt = bytearray(line)
        spoilt[place] ^= change
        assert remove_sum(spoilt.decode("latin-1")) is None
