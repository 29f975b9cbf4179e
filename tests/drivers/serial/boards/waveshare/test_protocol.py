from __future__ import annotations

import pytest

from drivers.serial.boards.waveshare.protocol import MAX_LINE_LENGTH, Parser, TrackFeedback, build_greeting
from tests.doubles.serial.waveshare import WaveshareBoard

FEEDBACK_LINE = WaveshareBoard().feedback()

OLDER = b'{"T":1001,"L":0,"R":0,"r":-89.1,"p":1.5,"y":36.5,"temp":40.2,"v":12.05}\r\n'
"""Feedback of ugv_base_general of July 2024: its voltage is in volts, and it has no odometer."""


def test_a_greeting_ends_a_cut_line_stops_the_board_and_sets_its_own_time_out_first() -> None:
    assert build_greeting(0.3).split(b"\n")[:3] == [b"", b'{"T":1,"L":0.0000,"R":0.0000}', b'{"T":136,"cmd":300}']


@pytest.mark.parametrize(
    "line, left, right, centivolts",
    [
        (b'{"T":1001,"L":0,"R":0,"odl":0,"odr":0,"v":1187}\r\n', (0, 0), (0, 0), 1187),
        (b'{"T":1001,"L":0.333333333,"R":-3.2e-7,"odl":12,"odr":-3,"v":0}\r\n', (12, 0.333333333), (-3, -3.2e-7), 0),
        (b'{"T":1001,"L":0,"R":0,"odl":0,"odr":0,"v":1187,"pan":0.5,"tilt":-3}\r\n', (0, 0), (0, 0), 1187),
    ],
)  # fmt: skip
def test_feedback_is_read(line: bytes, left: TrackFeedback, right: TrackFeedback, centivolts: int) -> None:
    [feedback] = Parser().feed(line)
    assert (feedback.track("left"), feedback.track("right"), feedback.centivolts) == (left, right, centivolts)


def test_another_line_is_dropped_and_the_next_one_parsed() -> None:
    for line in [
        b"Initialize LittleFS for Flash files ctrl.\r\n",
        b"rst:0x1 (POWERON_RESET),boot:0x13 (SPI_FAST_FLASH_BOOT)\r\n",
        b'{"T":1,"L":0.5,"R":0.5}\n',
        b'{"T":1002,"gx":0,"gy":0,"gz":0}\r\n',
        b'{"T":1005,"id":11,"status":0}\r\n',
        b"[1001]\r\n",
        b"1001\r\n",
        b"\r\n",
        b"\xff\xfe{}\r\n",
        b"{" * (MAX_LINE_LENGTH - 1) + b"\n",
        b'{"a":' * 90 + b"\n",
        FEEDBACK_LINE.replace(b'"odl":0', b'"odl":0.5'),
        FEEDBACK_LINE.replace(b'"odl":0', b'"odl":"0"'),
        FEEDBACK_LINE.replace(b'"odl":0', b'"odl":true'),
        FEEDBACK_LINE.replace(b'"odl":0', b'"odl":' + b"9" * 40),
        FEEDBACK_LINE.replace(b'"L":0', b'"L":null'),
        FEEDBACK_LINE.replace(b'"L":0', b'"L":NaN'),
        FEEDBACK_LINE.replace(b'"L":0', b'"L":1e400'),
        FEEDBACK_LINE.replace(b'"L":0', b'"L":1e9'),
        FEEDBACK_LINE.replace(b'"v":1187', b'"v":99999'),
        FEEDBACK_LINE.replace(b'"v":', b'"w":"' + b"w" * MAX_LINE_LENGTH + b'","v":'),
        FEEDBACK_LINE[:-5] + b"\r\n",
        FEEDBACK_LINE[5:],
        FEEDBACK_LINE[:40] + FEEDBACK_LINE,
        OLDER,
    ]:
        assert len(Parser().feed(line + FEEDBACK_LINE)) == 1, line


@pytest.mark.parametrize(
    "line, is_older", [(OLDER, True), (FEEDBACK_LINE, False), (FEEDBACK_LINE[:40] + b"\r\n", False)]
)
def test_the_older_firmware_is_detected_by_its_feedback(line: bytes, is_older: bool) -> None:
    parser = Parser()
    parser.feed(line)
    assert parser.is_older is is_older
