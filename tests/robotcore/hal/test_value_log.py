from __future__ import annotations

import math
from enum import Enum
from typing import Any

import numpy as np
import pytest

from robotcore.errors import UsageError
from robotcore.hal.value_log import MAX_NAMES, MAX_TEXT_LENGTH, LoggedValue, ValueLog
from tests.texts import Raises


class Phase(str, Enum):
    TURN = "turn"


def test_last_value_of_a_name_in_a_tick_holds_and_the_next_tick_begins_empty() -> None:
    log = ValueLog()
    for number in range(10_000):
        log.add("count", number)
    log.add("speed", 0.2, "m/s")
    assert log.take() == {"count": LoggedValue(9999), "speed": LoggedValue(0.2, "m/s")}
    assert log.take() == {}


@pytest.mark.parametrize(
    "value, plain",
    [
        (True, True),
        (np.bool_(False), False),
        (-(2**53), -(2**53)),
        (np.int32(3), 3),
        (np.float32(0.5), 0.5),
        (np.longdouble(0.5), 0.5),
        (np.array(0.5), 0.5),
        (math.inf, math.inf),
        ("two\nlines", "two\nlines"),
        ("a\udc80", "a\\udc80"),
        (Phase.TURN, "turn"),
        ("x" * MAX_TEXT_LENGTH, "x" * MAX_TEXT_LENGTH),
    ],
)
def test_value_is_logged_as_a_plain_number_boolean_or_text(value: Any, plain: object) -> None:
    log = ValueLog()
    log.add("it", value)
    logged = log.take()["it"].value
    assert (logged, type(logged)) == (plain, type(plain))


def test_nan_is_logged() -> None:
    log = ValueLog()
    log.add("error", math.nan, "rad")
    assert math.isnan(float(log.take()["error"].value))


def test_integer_and_fraction_are_both_numbers() -> None:
    log = ValueLog()
    log.add("size", 1)
    log.add("size", 0.5)
    assert log.take()["size"].value == 0.5


def test_name_may_be_a_member_of_an_enumeration() -> None:
    log = ValueLog()
    log.add(Phase.TURN, 1)
    (name,) = log.take()
    assert type(name) is str


@pytest.mark.parametrize("name", ["", 3, None, [], "two words", "1st", "größe", "a/b", "a\n", "\ud800", "a" * 65])
def test_invalid_name_is_refused(raises: Raises, name: Any) -> None:
    with raises(UsageError, "log-name"):
        ValueLog().add(name, 1)


@pytest.mark.parametrize(
    "value",
    [None, [1.0], np.zeros(3), 1j, 2**53 + 1, 10**5000, "x" * 201, "\udc80" * 100, b"bytes"],
    ids=["none", "list", "array", "complex", "integer", "huge", "text", "surrogates", "bytes"],
)
def test_value_that_is_no_number_boolean_or_short_text_is_refused(raises: Raises, value: Any) -> None:
    with raises(UsageError, "log-value", name="'speed'"):
        ValueLog().add("speed", value)


@pytest.mark.parametrize("unit", [None, 3, "m" * 17, "m\n", "\ud800"])
def test_invalid_unit_is_refused(raises: Raises, unit: Any) -> None:
    with raises(UsageError, "log-unit"):
        ValueLog().add("speed", 1, unit)


@pytest.mark.parametrize("value, unit", [(True, "m"), ("1", "m"), (1, ""), (1, "mm")])
def test_name_keeps_its_type_and_its_unit(raises: Raises, value: Any, unit: str) -> None:
    log = ValueLog()
    log.add("way", 0.5, "m")
    log.take()
    with raises(UsageError, "log-changed", name="'way'"):
        log.add("way", value, unit)
    assert log.take() == {}


def test_number_of_names_in_a_run_is_limited(raises: Raises) -> None:
    log = ValueLog()
    for number in range(MAX_NAMES):
        log.add(f"n{number}", 1)
        log.take()
    with raises(UsageError, "log-names"):
        log.add("one_more", 1)
    log.add("n0", 2)
    assert list(log.take()) == ["n0"]
