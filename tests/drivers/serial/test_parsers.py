"""Rules of every parser, with random damage to the stream."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from random import Random
from typing import NamedTuple, Protocol

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.serial.boards.hoverboard.protocol import Parser as HoverboardParser
from drivers.serial.boards.rosarduino.protocol import Parser as ArduinoParser
from drivers.serial.boards.waveshare.protocol import Parser as WaveshareParser
from drivers.serial.ranging.ld06 import Parser as LD06Parser
from drivers.serial.ranging.protocol import Parser as TFminiParser
from tests.doubles.serial.hoverboard import feedback
from tests.doubles.serial.lidars import build_packet
from tests.doubles.serial.tfmini import frame

MAX_STORED = 2000
"""The largest size of a pickled parser in bytes."""


class Parser(Protocol):
    """The interface of every parser."""

    def feed(self, data: bytes) -> Sequence[object]: ...


class ParserCase(NamedTuple):
    """A parser with frames of its board."""

    name: str
    parser: Callable[[], Parser]
    frame: Callable[[Random], bytes]
    """Returns a random valid frame."""
    start_bytes: bytes
    """The bytes with which a frame may begin. In noise, they look like frames."""
    detectable: frozenset[str]
    """The damage that a checksum or the format shows. After other damage, any parser may return wrong values."""

    def __str__(self) -> str:
        return self.name

    def parse_frame(self, frame: bytes) -> object:
        """Return the content of a frame. A parser may accept a frame only before another one."""
        return self.parser().feed(2 * frame)[0]


def _range(draw: Random) -> bytes:
    distance = draw.choice((draw.randrange(1200), 0x59, 0x0259, 0, 0xFFFF, 0xFFFE, 0xFFFC))
    return frame(distance, draw.choice((draw.randrange(0x10000), 0x5959)), draw.randrange(1800, 2600))


def _packet(draw: Random) -> bytes:
    distances = [draw.choice((draw.uniform(0.02, 12.0), float("inf"), 0x2C54 / 1000)) for _ in range(12)]
    return build_packet(draw.uniform(0, 360), draw.uniform(0.4, 1.1), distances, draw.uniform(0, 30))


def _wheels(draw: Random) -> bytes:
    return feedback(*(draw.randint(-1000, 1000) for _ in range(4)), draw.randint(3000, 4200), 300, draw.randrange(256))


def _object(draw: Random) -> bytes:
    speeds = b'"L":%.4f,"R":%.4f' % (draw.uniform(-2, 2), draw.uniform(-2, 2))
    ways = b'"odl":%d,"odr":%d' % (draw.randint(-99999, 99999), draw.randint(-99999, 99999))
    return b'{"T":1001,%b,"gx":%d,%b,"v":%d}\r\n' % (speeds, draw.randint(-999, 999), ways, draw.randint(900, 1260))


def _line(draw: Random) -> bytes:
    return b"%d %d\r\n" % (draw.randint(-(2**31), 2**31 - 1), draw.randint(-9999, 9999))


NOISE, CUT, CHANGED = "noise between frames", "a frame without its start or its end", "a frame with one wrong byte"
PARSERS = (
    ParserCase("tfmini", TFminiParser, _range, b"\x59\x00\x08", frozenset({NOISE, CUT, CHANGED})),
    ParserCase("ld06", LD06Parser, _packet, b"\x54\x2c", frozenset({NOISE, CUT, CHANGED})),
    ParserCase("hoverboard", HoverboardParser, _wheels, b"\xcd\xab\x00", frozenset({NOISE, CUT, CHANGED})),
    # The beginning of a line of Waveshare's, and the end of another one, may be a whole line: they have no checksum.
    ParserCase("waveshare", WaveshareParser, _object, b'{}":,\r\n"T":1001', frozenset({NOISE})),
    # ROSArduinoBridge has no checksum, and two additional equal letters keep the XOR of robotcore_bridge.
    ParserCase("ros-arduino", ArduinoParser, _line, b"0123456789 -*\r\n", frozenset()),
)
every_parser = pytest.mark.parametrize("case", PARSERS, ids=str)
few_examples = settings(max_examples=25, deadline=None)


def build_frames(case: ParserCase) -> st.SearchStrategy[bytes]:
    return st.integers(0, 2**32).map(lambda seed: case.frame(Random(seed)))


def build_noise(case: ParserCase) -> st.SearchStrategy[bytes]:
    """Return a strategy of arbitrary bytes, often with starts of frames."""
    starts = st.sampled_from([bytes([start_byte]) for start_byte in case.start_bytes])
    return st.lists(st.one_of(starts, st.binary(max_size=4)), max_size=40).map(b"".join)


def damage_frames(
    case: ParserCase, frames: st.SearchStrategy[bytes], kinds: frozenset[str] = frozenset({NOISE, CUT, CHANGED})
) -> st.SearchStrategy[bytes]:
    """Return a strategy of damaged frames, and of noise in place of a frame."""
    made = {
        NOISE: build_noise(case),
        CUT: st.builds(_cut_frame, frames, st.integers(1, 100), st.booleans()),
        CHANGED: st.builds(_change_byte, frames, st.integers(0, 100), st.integers(1, 255)),
    }
    return st.one_of([made[kind] for kind in sorted(kinds)])


def _cut_frame(frame: bytes, length: int, is_at_the_end: bool) -> bytes:
    left = 1 + length % (len(frame) - 1)
    return frame[:left] if is_at_the_end else frame[left:]


def _change_byte(frame: bytes, where: int, by: int) -> bytes:
    where %= len(frame)
    return frame[:where] + bytes([frame[where] ^ by]) + frame[where + 1 :]


@every_parser
@few_examples
@given(st.data())
def test_cuts_of_the_stream_change_nothing(case: ParserCase, data: st.DataObject) -> None:
    frames = build_frames(case)
    stream = b"".join(data.draw(st.lists(st.one_of(frames, damage_frames(case, frames)), max_size=8)))
    cuts = data.draw(st.lists(st.integers(0, len(stream)), max_size=20).map(sorted))
    pieces = [stream[start:end] for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    parser = case.parser()
    assert [value for piece in pieces for value in parser.feed(piece)] == list(case.parser().feed(stream))


@every_parser
@few_examples
@given(st.data())
def test_every_frame_of_a_clean_line_is_reported(case: ParserCase, data: st.DataObject) -> None:
    frames = data.draw(st.lists(build_frames(case), min_size=2, max_size=8))
    assert list(case.parser().feed(b"".join(frames))) == [case.parse_frame(frame) for frame in frames]


@every_parser
@few_examples
@given(st.data())
def test_no_value_is_reported_that_no_frame_carried(case: ParserCase, data: st.DataObject) -> None:
    whole = data.draw(st.lists(build_frames(case), min_size=1, max_size=4))
    repeated = st.sampled_from(whole)
    damaged = [damage_frames(case, repeated, case.detectable)] if case.detectable else []
    stream = data.draw(st.lists(st.one_of(repeated, *damaged), max_size=12))
    true = [case.parse_frame(frame) for frame in whole]
    assert all(value in true for value in case.parser().feed(b"".join(stream)))


@every_parser
@few_examples
@given(st.data())
def test_the_second_frame_after_damage_is_found(case: ParserCase, data: st.DataObject) -> None:
    frames = build_frames(case)
    before = data.draw(st.lists(st.one_of(frames, damage_frames(case, frames)), max_size=8))
    after = data.draw(st.lists(frames, min_size=3, max_size=5))
    parser = case.parser()
    parser.feed(b"".join(before))
    in_step = [case.parse_frame(frame) for frame in after[2:]]
    assert list(parser.feed(b"".join(after)))[-len(in_step) :] == in_step


@every_parser
@few_examples
@given(st.data())
def test_any_bytes_neither_raise_nor_fill_memory(case: ParserCase, data: st.DataObject) -> None:
    parser = case.parser()
    for piece in data.draw(st.lists(build_noise(case), max_size=20)):
        parser.feed(piece)
    assert len(pickle.dumps(parser)) < MAX_STORED


@every_parser
def test_a_stream_of_frame_starts_alone_is_not_stored(case: ParserCase) -> None:
    for unit in (case.start_bytes, *(bytes([one]) for one in case.start_bytes)):
        parser = case.parser()
        parser.feed(unit * 20_000)
        assert len(pickle.dumps(parser)) < MAX_STORED
