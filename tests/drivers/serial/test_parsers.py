"""Rules of every parser, with random damage to the stream."""

from __future__ import annotations

import pickle
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.doubles.serial.protocols import ANY, PARSER_CASES, Damage, Parser, ParserCase

EXAMPLES = 25
"""The number of random examples of each rule and parser. Each run of the suite draws other examples."""

MAX_STORED = 2000
"""The largest size of a pickled parser in bytes."""

every_parser = pytest.mark.parametrize("case", PARSER_CASES, ids=str)

NOISE = 40
"""The maximum number of bytes of noise between frames."""


def build_frames(case: ParserCase) -> st.SearchStrategy[bytes]:
    return st.integers(0, 2**32).map(lambda seed: case.frame(Random(seed)))


def build_noise(case: ParserCase) -> st.SearchStrategy[bytes]:
    """Return a strategy of arbitrary bytes, often with starts of frames."""
    marked = st.lists(st.sampled_from([bytes([start_byte]) for start_byte in case.start_bytes]), max_size=NOISE).map(
        b"".join
    )
    return st.one_of(
        st.binary(max_size=NOISE), marked, st.lists(st.one_of(marked, st.binary(max_size=4))).map(b"".join)
    )


def damage_frames(case: ParserCase, frames: st.SearchStrategy[bytes], kinds: Damage = ANY) -> st.SearchStrategy[bytes]:
    """Return a strategy of damaged frames, and of noise in place of a frame."""
    made = {
        Damage.NOISE: build_noise(case),
        Damage.CUT: st.builds(_cut_frame, frames, st.integers(1, 100), st.booleans()),
        Damage.CHANGED: st.builds(_change_byte, frames, st.integers(0, 100), st.integers(1, 255)),
    }
    return st.one_of([made[kind] for kind in Damage if kind in kinds])


@pytest.mark.slow
@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_cuts_of_the_stream_change_nothing(case: ParserCase, data: st.DataObject) -> None:
    frames = build_frames(case)
    stream = b"".join(data.draw(st.lists(st.one_of(frames, damage_frames(case, frames)), max_size=8)))
    cuts = data.draw(st.lists(st.integers(0, len(stream)), max_size=20).map(sorted))
    pieces = [stream[start:end] for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    parser = case.parser()
    assert [value for piece in pieces for value in parser.feed(piece)] == list(case.parser().feed(stream))


@every_parser
def test_single_bytes_make_the_same_frames(case: ParserCase) -> None:
    draw = Random(1)
    stream = b"".join(case.frame(draw) + draw.randbytes(draw.randrange(20)) for _ in range(400))
    parser = case.parser()
    assert [value for byte in stream for value in parser.feed(bytes([byte]))] == list(case.parser().feed(stream))


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_every_frame_of_a_clean_line_is_reported(case: ParserCase, data: st.DataObject) -> None:
    frames = data.draw(st.lists(build_frames(case), min_size=2, max_size=8))
    assert list(case.parser().feed(b"".join(frames))) == [_parse_frame(case, frame) for frame in frames]


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_no_value_is_reported_that_no_frame_carried(case: ParserCase, data: st.DataObject) -> None:
    whole = data.draw(st.lists(build_frames(case), min_size=1, max_size=4))
    repeated = st.sampled_from(whole)
    stream = data.draw(st.lists(st.one_of(repeated, damage_frames(case, repeated, case.detectable)), max_size=12))
    true = [_parse_frame(case, frame) for frame in whole]
    assert all(value in true for value in case.parser().feed(b"".join(stream)))


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_the_second_frame_after_damage_is_found(case: ParserCase, data: st.DataObject) -> None:
    frames = build_frames(case)
    before = data.draw(st.lists(st.one_of(frames, damage_frames(case, frames)), max_size=8))
    after = data.draw(st.lists(frames, min_size=3, max_size=5))
    parser = case.parser()
    parser.feed(b"".join(before))
    parsed = list(parser.feed(b"".join(after)))
    in_step = [_parse_frame(case, frame) for frame in after[2:]]
    assert parsed[-len(in_step) :] == in_step


@pytest.mark.slow
@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_any_bytes_neither_raise_nor_fill_memory(case: ParserCase, data: st.DataObject) -> None:
    parser = case.parser()
    for piece in data.draw(st.lists(build_noise(case), max_size=20)):
        parser.feed(piece)
    assert _pickled_size(parser) < MAX_STORED


@every_parser
@pytest.mark.parametrize("stream", ["each-start-byte", "all-start-bytes"])
def test_a_stream_of_frame_starts_alone_is_not_stored(case: ParserCase, stream: str) -> None:
    units = [bytes([one]) for one in case.start_bytes] if stream == "each-start-byte" else [case.start_bytes]
    for unit in units:
        parser = case.parser()
        parser.feed(unit * 20_000)
        assert _pickled_size(parser) < MAX_STORED


def _parse_frame(case: ParserCase, frame: bytes) -> object:
    """Return the content of a frame. It is fed twice, because a parser may accept a frame only before another one."""
    return case.parser().feed(2 * frame)[0]


def _pickled_size(parser: Parser) -> int:
    return len(pickle.dumps(parser))


def _cut_frame(frame: bytes, length: int, is_at_the_end: bool) -> bytes:
    left = 1 + length % (len(frame) - 1)
    return frame[:left] if is_at_the_end else frame[left:]


def _change_byte(frame: bytes, where: int, by: int) -> bytes:
    where %= len(frame)
    return frame[:where] + bytes([frame[where] ^ by]) + frame[where + 1 :]
