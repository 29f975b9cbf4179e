"""Rules of every parser, with any damage to the stream."""

from __future__ import annotations

import pickle
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.doubles.serial.protocols import ANY, PARSER_CASES, Damage, Parser, ParserCase

EXAMPLES = 25
"""The examples of each rule and parser; every run of the suite draws others."""

KEPT = 2000
"""The largest size of a pickled parser in bytes."""

every_parser = pytest.mark.parametrize("spoken", PARSER_CASES, ids=str)

NOISE = 40
"""The most bytes between frames."""


def frames_of(spoken: ParserCase) -> st.SearchStrategy[bytes]:
    return st.integers(0, 2**32).map(lambda seed: spoken.frame(Random(seed)))


def noise_for(spoken: ParserCase) -> st.SearchStrategy[bytes]:
    """Any bytes, often with starts of frames."""
    marked = st.lists(st.sampled_from([bytes([mark]) for mark in spoken.marks]), max_size=NOISE).map(b"".join)
    return st.one_of(
        st.binary(max_size=NOISE), marked, st.lists(st.one_of(marked, st.binary(max_size=4))).map(b"".join)
    )


def damaged(spoken: ParserCase, frames: st.SearchStrategy[bytes], kinds: Damage = ANY) -> st.SearchStrategy[bytes]:
    """A damaged frame, or noise in its place."""
    made = {
        Damage.NOISE: noise_for(spoken),
        Damage.CUT: st.builds(_cut, frames, st.integers(1, 100), st.booleans()),
        Damage.CHANGED: st.builds(_changed, frames, st.integers(0, 100), st.integers(1, 255)),
    }
    return st.one_of([made[kind] for kind in Damage if kind in kinds])


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_cuts_of_the_stream_change_nothing(spoken: ParserCase, data: st.DataObject) -> None:
    frames = frames_of(spoken)
    stream = b"".join(data.draw(st.lists(st.one_of(frames, damaged(spoken, frames)), max_size=8)))
    cuts = data.draw(st.lists(st.integers(0, len(stream)), max_size=20).map(sorted))
    pieces = [stream[start:end] for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    parser = spoken.parser()
    assert [value for piece in pieces for value in parser.feed(piece)] == list(spoken.parser().feed(stream))


@every_parser
def test_single_bytes_make_the_same_frames(spoken: ParserCase) -> None:
    draw = Random(1)
    stream = b"".join(spoken.frame(draw) + draw.randbytes(draw.randrange(20)) for _ in range(400))
    parser = spoken.parser()
    assert [value for byte in stream for value in parser.feed(bytes([byte]))] == list(spoken.parser().feed(stream))


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_every_frame_of_a_clean_line_is_reported(spoken: ParserCase, data: st.DataObject) -> None:
    frames = data.draw(st.lists(frames_of(spoken), min_size=2, max_size=8))
    assert list(spoken.parser().feed(b"".join(frames))) == [_said(spoken, frame) for frame in frames]


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_no_value_is_reported_that_no_frame_carried(spoken: ParserCase, data: st.DataObject) -> None:
    whole = data.draw(st.lists(frames_of(spoken), min_size=1, max_size=4))
    repeated = st.sampled_from(whole)
    stream = data.draw(st.lists(st.one_of(repeated, damaged(spoken, repeated, spoken.seen)), max_size=12))
    true = [_said(spoken, frame) for frame in whole]
    assert all(value in true for value in spoken.parser().feed(b"".join(stream)))


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_the_second_frame_after_damage_is_found(spoken: ParserCase, data: st.DataObject) -> None:
    frames = frames_of(spoken)
    before = data.draw(st.lists(st.one_of(frames, damaged(spoken, frames)), max_size=8))
    after = data.draw(st.lists(frames, min_size=3, max_size=5))
    parser = spoken.parser()
    parser.feed(b"".join(before))
    parsed = list(parser.feed(b"".join(after)))
    in_step = [_said(spoken, frame) for frame in after[2:]]
    assert parsed[-len(in_step) :] == in_step


@every_parser
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.data())
def test_any_bytes_neither_raise_nor_fill_memory(spoken: ParserCase, data: st.DataObject) -> None:
    parser = spoken.parser()
    for piece in data.draw(st.lists(noise_for(spoken), max_size=20)):
        parser.feed(piece)
    assert _kept(parser) < KEPT


@every_parser
@pytest.mark.parametrize("mark", ["each mark", "all marks"])
def test_a_stream_of_nothing_but_beginnings_is_not_kept(spoken: ParserCase, mark: str) -> None:
    streams = [bytes([one]) for one in spoken.marks] if mark == "each mark" else [spoken.marks]
    for stream in streams:
        parser = spoken.parser()
        parser.feed(stream * 20_000)
        assert _kept(parser) < KEPT


def _said(spoken: ParserCase, frame: bytes) -> object:
    """Return the values of a frame; the parser may need a second frame to accept the first one."""
    return spoken.parser().feed(2 * frame)[0]


def _kept(parser: Parser) -> int:
    return len(pickle.dumps(parser))


def _cut(frame: bytes, length: int, is_at_the_end: bool) -> bytes:
    left = 1 + length % (len(frame) - 1)
    return frame[:left] if is_at_the_end else frame[left:]


def _changed(frame: bytes, where: int, by: int) -> bytes:
    where %= len(frame)
    return frame[:where] + bytes([frame[where] ^ by]) + frame[where + 1 :]
