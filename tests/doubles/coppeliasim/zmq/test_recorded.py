"""Compare the double with a real server: send each recorded request, and compare each reply."""

from __future__ import annotations

from typing import Any

import pytest

from tests.doubles.coppeliasim.replaying.comparison import Tolerance, find_differences
from tests.doubles.coppeliasim.replaying.replay import SESSIONS, load_session, replay_on_double
from tests.doubles.coppeliasim.zmq.session import table
from tests.doubles.coppeliasim.zmq.wire import dumps, loads


@pytest.mark.slow
@pytest.mark.parametrize("file", SESSIONS)
def test_each_reply_equals_the_real_servers(file: str) -> None:
    assert replay_on_double(file) == []


def test_each_session_has_exchanges() -> None:
    assert {file: len(load_session(file)) for file in SESSIONS} == {
        "zmq-session.jsonl": 161,
        "zmq-session-2.jsonl": 207,
    }


def test_recorded_reply_is_encoded_byte_by_byte() -> None:
    kept = [each for file in SESSIONS for each in load_session(file) if each.raw is not None]
    assert len(kept) > 300
    for each in kept:
        assert dumps(each.reply) == each.raw


def test_table_of_functions_has_the_recorded_length() -> None:
    assert len(dumps({"ret": [table()]})) == 62543


@pytest.mark.parametrize(
    "reply",
    [
        {"ret": [1.0]},
        {"ret": [1, 2]},
        {"err": "no"},
        {"ret": {}},
        {"ret": ["1"]},
    ],
)
def test_other_reply_is_a_difference(reply: dict[str, Any]) -> None:
    assert list(find_differences({"ret": [1]}, reply))


def test_tolerance_applies_to_numbers_only() -> None:
    near = Tolerance(number=0.1, pixels=1.0)
    assert not list(find_differences([1.0, b"abc"], [1.05, b"abd"], near))
    assert list(find_differences([1.0], [1.2], near))
    assert list(find_differences([b"abc"], [b"axc"], near))
    assert list(find_differences([3], [3.05], near))


@pytest.mark.parametrize("value", [0, 23, 24, 255, 256, 2**32, -1, -25, 0.5, 0.1, 1e5, 1e300, float("inf"), None, True])
def test_encoded_value_is_decoded(value: Any) -> None:
    assert loads(dumps({"ret": [value, "ä", b"\0\xff", [], {}]})) == {"ret": [value, "ä", b"\0\xff", [], {}]}
