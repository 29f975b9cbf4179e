"""Encoding and decoding of events."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from robotcore.geometry import Wheels
from robotcore.kinds.encoder import Angle
from robotcore.kinds.range_sensor import Range
from robotcore.recording import GroundTruthSample, RecordedError, Tick
from robotcore.recording.codec import from_json, to_json, to_plain
from robotcore.recording.events import ActuatorCommand
from robotcore.runtime.behaviour import Status

names = st.text(max_size=8)
attributes = st.dictionaries(names, st.floats(allow_nan=False, allow_infinity=False))
st.register_type_strategy(RecordedError, st.builds(RecordedError, names, names, attributes))
plain = st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | names | attributes
st.register_type_strategy(ActuatorCommand, st.builds(ActuatorCommand, names, plain, plain, st.from_type(RecordedError)))


@pytest.mark.slow
@given(st.from_type(Tick) | st.from_type(GroundTruthSample) | st.from_type(Range) | st.from_type(Angle))
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
    values = [np.float64(0.1), np.int64(3), np.bool_(True), Status.RUNNING]
    assert to_plain(values) == [0.1, 3, True, "running"]


@pytest.mark.parametrize("left", [np.float64(0.5), np.float32(0.5), np.array([0.5, 1.0])])
def test_numpy_values_in_a_dataclass_become_plain_values(left: Any) -> None:
    assert to_plain(Wheels(left, 1.0)) == {"left": left.tolist(), "right": 1.0}


@dataclass(frozen=True)
class Markers:
    nearest: float | None
    distances: tuple[float, ...]
    label: str | None = None


def test_required_fields_with_none_or_an_empty_tuple_are_read_again() -> None:
    assert from_json(Markers, to_json(Markers(None, ()))) == Markers(None, ())


@pytest.mark.parametrize("text", [rb"\ud800", rb"a\uDC80b", rb"\ud83d \ude00", b"\xed\xa0\x80"])
def test_lone_surrogate_is_refused_in_any_string(text: bytes) -> None:
    for content in (b'{"kind":"%s","message":""}', b'{"kind":"","message":"","attributes":{"%s":1}}'):
        with pytest.raises(ValidationError):
            from_json(RecordedError, content % text)


def test_unknown_field_of_another_version_is_ignored() -> None:
    content = b'{"number":1,"time":0,"state":"","standing":[{"left":1.0,"right":1.0}]}'
    assert from_json(Tick, content) == Tick(1, 0.0, "")


def test_lone_surrogate_of_a_run_is_recorded_as_an_escape() -> None:
    assert from_json(RecordedError, to_json(RecordedError("a\udc80", "", {"\udc80": 1}))) == RecordedError(
        "a\\udc80", "", {"\\udc80": 1}
    )
