"""Compare the double with the recorded sessions of a real server."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from typing import Any

import pytest

from tests.doubles.coppeliasim.legacy.codec import encode_packets, pack, read_message, unpack
from tests.doubles.coppeliasim.replay import (
    LEGACY_SESSIONS,
    RECORDED,
    ZMQ_SESSIONS,
    find_differences,
    load_zmq_session,
    replay_legacy_session,
    replay_zmq_session,
)


@pytest.mark.parametrize("file", ZMQ_SESSIONS)
def test_each_zmq_reply_equals_the_real_servers(file: str) -> None:
    assert replay_zmq_session(file) == []


@pytest.mark.parametrize("file", LEGACY_SESSIONS)
def test_each_legacy_call_returns_the_official_bindings_result(file: str) -> None:
    assert replay_legacy_session(file) == []


def test_sessions_have_exchanges() -> None:
    assert [len(list(load_zmq_session(file))) for file in ZMQ_SESSIONS] == [154, 176]


@pytest.mark.parametrize("direction", ["client", "server"])
@pytest.mark.parametrize("file", ["legacy-wire.jsonl", "legacy-wire-2.jsonl", "legacy-wire-19999.jsonl"])
def test_recorded_messages_are_encoded_again(file: str, direction: str) -> None:
    for message in read_recorded_messages(file, direction):
        header, commands = unpack(message)
        assert unpack(pack(header, commands)) == (header, commands)
        assert len(pack(header, commands)) == len(message)
        assert read_message(io.BytesIO(encode_packets(message)).read) == message


def read_recorded_messages(file: str, direction: str) -> Iterator[bytes]:
    rows = [json.loads(row) for row in (RECORDED / file).read_text().splitlines()]
    line = io.BytesIO(b"".join(bytes.fromhex(row["hex"]) for row in rows if row["dir"] == direction))
    while line.tell() < len(line.getbuffer()):
        yield read_message(line.read)


@pytest.mark.parametrize(
    "recorded, result, tolerance, is_equal",
    [
        ([1, "a"], (1, "a"), 0.0, True),
        ([1], [1.0], 0.0, False),
        ([1.0], [1.05], 0.1, True),
        ([1.0], [1.2], 0.1, False),
        ({"ret": [1]}, {"err": "no"}, 0.0, False),
        (b"abc", b"abd", 0.0, True),
        (b"aaa", b"zzz", 0.0, False),
    ],
)
def test_difference_is_found(recorded: Any, result: Any, tolerance: float, *, is_equal: bool) -> None:
    assert (not list(find_differences(recorded, result, tolerance))) is is_equal
