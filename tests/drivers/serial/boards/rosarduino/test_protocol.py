from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.serial.boards.rosarduino.protocol import (
    BATTERY,
    COUNTS,
    LONGEST_LINE,
    STOP,
    Answer,
    Parser,
    Question,
    checked,
    deadman,
    framed,
    ping,
    speeds,
    still_there,
    who_is_there,
)

REFUSED = "Invalid Command"


@pytest.mark.parametrize(
    "question, sent, line, answer",
    [
        (COUNTS, b"e\r", "118 -120", Answer((118, -120))),
        (COUNTS, b"e\r", "118", None),
        (COUNTS, b"e\r", "118 ", None),
        (COUNTS, b"e\r", "OK", None),
        (COUNTS, b"e\r", REFUSED, Answer(is_refusal=True)),
        (speeds(20, -3), b"m 20 -3\r", "OK", Answer()),
        (STOP, b"m 0 0\r", "0 0", None),
        (BATTERY, b"y\r", "-1", Answer((-1,))),
        (deadman(500), b"k 500\r", "OK", Answer()),
        (ping(7), b"p 7\r", "52", Answer((52,))),
        (ping(7), b"p 7\r", "57600", None),
        (ping(7), b"p 7\r", "-1", None),
        (who_is_there(57600), b"\rm 0 0\rv*76\rb\r", "57600", Answer((57600,))),
        (who_is_there(57600), b"\rm 0 0\rv*76\rb\r", "robotcore-bridge 1", Answer((1,))),
        (who_is_there(57600), b"\rm 0 0\rv*76\rb\r", REFUSED, None),
        (still_there(57600, 1.0, is_summed=False), b"\rb\r", "5760", None),
        (still_there(57600, 1.0, is_summed=True), b"\rv*76\r", "57600", None),
    ],
)
def test_an_answer_is_known_by_its_shape(question: Question, sent: bytes, line: str, answer: Answer | None) -> None:
    assert question.frame(is_summed=False) == sent
    assert question.answer(line) == answer


@given(st.lists(st.from_regex(r"[ -~]{0,40}", fullmatch=True), max_size=5), st.data())
def test_lines_are_the_same_in_whatever_pieces_they_come(lines: list[str], data: st.DataObject) -> None:
    stream = "".join(f"{line}\r\n" for line in lines).encode()
    cuts = [0, *sorted(data.draw(st.lists(st.integers(0, len(stream))))), len(stream)]
    parser = Parser()
    heard = [line for start, end in itertools.pairwise(cuts) for line in parser.feed(stream[start:end])]
    assert heard == lines


@given(st.lists(st.binary(max_size=200)))
def test_whatever_comes_in_the_next_line_but_one_is_read(noise: list[bytes]) -> None:
    parser = Parser()
    for piece in noise:
        assert all(len(line) <= LONGEST_LINE for line in parser.feed(piece))
    assert parser.feed(b"1 2\r\n3 4\r\n")[-1] == "3 4"


@given(st.from_regex(r"[ -~]{1,20}", fullmatch=True), st.integers(0, 18), st.integers(1, 127))
def test_one_byte_that_differs_is_seen_by_the_sum(text: str, place: int, change: int) -> None:
    line = bytearray(framed(text, is_summed=True).removesuffix(b"\r"))
    assert checked(line.decode()) == text
    line[place % len(line)] ^= change
    assert checked(line.decode("latin-1")) is None


@pytest.mark.parametrize("noise", [b"9" * 100 + b"\r\n", b"5 \xff5\r\n"])
def test_a_line_that_is_none_is_counted_and_dropped(noise: bytes) -> None:
    parser = Parser()
    assert [line for byte in noise for line in parser.feed(bytes([byte]))] == []
    assert parser.dropped == 1
    assert parser.feed(b"OK\r\n") == ["OK"]
