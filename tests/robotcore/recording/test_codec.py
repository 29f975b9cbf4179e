"""Encoding and decoding of events."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from robotcore.geometry import Pose, Wheels
from robotcore.hal.devices import Angle, Range
from robotcore.recording import (
    DriveCommand,
    GroundTruthSample,
    MotorCommand,
    Read,
    RecordedError,
    ShownPicture,
    Tick,
    WheelAngles,
)
from robotcore.recording.codec import from_json, to_json, to_plain
from robotcore.safety import Intervention

doubles = st.floats()
names = st.text(max_size=8)
counts = st.integers(0, 2**53)
wheels = st.builds(Wheels, doubles, doubles)
raised = st.builds(
    RecordedError, names, names, st.dictionaries(names, st.floats(allow_nan=False, allow_infinity=False))
)
reads = st.builds(
    Read, names, st.none() | counts, st.none() | doubles, st.none() | counts, st.none() | raised, st.none() | names
)
asks = st.builds(DriveCommand, st.none() | wheels, st.none() | wheels, st.none() | raised)
motor_asks = st.builds(MotorCommand, names, st.none() | doubles, st.none() | doubles, st.none() | raised)
shown = st.builds(ShownPicture, names, st.none() | counts, st.none() | raised)
interventions = st.builds(Intervention, doubles, names, wheels, wheels)


def build_tuples(of: st.SearchStrategy[Any]) -> st.SearchStrategy[tuple[Any, ...]]:
    return st.lists(of, max_size=3).map(tuple)


ticks = st.builds(
    Tick,
    number=counts,
    time=doubles,
    state=names,
    reads=build_tuples(reads),
    asks=build_tuples(asks),
    motor_asks=build_tuples(motor_asks),
    turned=build_tuples(st.builds(WheelAngles, st.none() | wheels, st.none() | raised)),
    standing=build_tuples(wheels),
    pose=st.none() | st.builds(Pose, doubles, doubles, doubles),
    asked=st.none() | wheels,
    sent=st.none() | wheels,
    interventions=build_tuples(interventions),
    commit_error=st.none() | raised,
    shown=build_tuples(shown),
    error=st.none() | raised,
)
points = st.none() | st.tuples(doubles, doubles, doubles)
events = (
    ticks
    | st.builds(GroundTruthSample, counts, doubles, st.builds(Pose, doubles, doubles, doubles), counts)
    | st.builds(Range, doubles, doubles, counts, points)
    | st.builds(Angle, doubles, doubles, counts)
)


@pytest.mark.slow
@given(events)
def test_decoded_event_has_the_same_doubles(event: Any) -> None:
    again = from_json(type(event), to_json(event))
    assert type(again) is type(event)
    assert get_bits(again) == get_bits(event)


def get_bits(value: Any) -> Any:
    """Return a value with each double replaced by its bytes. Every NaN is the same."""
    if isinstance(value, float):
        return b"nan" if value != value else struct.pack("<d", value)  # noqa: PLR0124
    if hasattr(value, "__dataclass_fields__"):
        return [type(value), *(get_bits(getattr(value, name)) for name in value.__dataclass_fields__)]
    if isinstance(value, dict):
        return {name: get_bits(each) for name, each in value.items()}
    return [type(value), *map(get_bits, value)] if isinstance(value, tuple) else value


def test_non_finite_number_is_a_string_in_json() -> None:
    values = json.loads(to_json(Wheels(float("inf"), float("nan"))), parse_constant=pytest.fail)
    assert values == {"left": "inf", "right": "nan"}


def test_numpy_numbers_and_enumerations_become_plain_values() -> None:
    assert to_plain([np.float64(0.1), np.int64(3), np.bool_(True).item()]) == [0.1, 3, True]


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"number": "x"}', b'{"number": 1, "time": [], "state": ""}'])
def test_invalid_tick_is_refused(content: bytes) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  pydantic's, or json's
        from_json(Tick, content)


@pytest.mark.parametrize("text", [rb"\ud800", rb"a\uDC80b", rb"\ud83d \ude00", b"\xed\xa0\x80"])
def test_lone_surrogate_is_refused_in_any_string(text: bytes) -> None:
    for content in (b'{"kind":"%s","message":""}', b'{"kind":"","message":"","attributes":{"%s":1}}'):
        with pytest.raises(ValidationError):
            from_json(RecordedError, content % text)


def test_surrogate_pair_is_decoded() -> None:
    assert from_json(RecordedError, to_json(RecordedError("\U0001f600", ""))) == RecordedError("\U0001f600", "")


def test_lone_surrogate_of_a_run_is_recorded_as_an_escape() -> None:
    assert from_json(RecordedError, to_json(RecordedError("a\udc80", "", {"\udc80": 1}))) == RecordedError(
        "a\\udc80", "", {"\\udc80": 1}
    )
