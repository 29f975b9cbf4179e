from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from robotcore import Outcome
from robotcore.sweep import Record
from tests.robotcore.sweep.conftest import record_of


@pytest.mark.parametrize("path", [None, (), ((0.0, 1.0, 2.0), (0.5, 1.0, 2.1))])
def test_json_holds_a_record_in_whole(path: tuple[tuple[float, float, float], ...] | None) -> None:
    record = replace(record_of(), path=path, picture="failures/a.png")
    assert Record.from_json(record.to_json()) == record


def test_json_is_one_line_with_the_keys_of_the_result_first() -> None:
    line = record_of().to_json()
    assert "\n" not in line
    assert list(json.loads(line)) == [*json.loads(record_of().result.to_json()), "command", "path", "picture"]


def test_numbers_that_json_does_not_have_are_unknown_and_their_points_left_out() -> None:
    record = replace(record_of(), path=((0.0, 1.0, 2.0), (0.5, math.nan, 2.0), (1.0, 1.0, math.inf)))
    record = replace(record, result=replace(record.result, distance_to_target_m=math.nan))
    told = json.loads(record.to_json(), parse_constant=pytest.fail)
    assert (told["path"], told["distance_to_target_m"]) == ([[0.0, 1.0, 2.0]], None)


@pytest.mark.parametrize("line", ["", "{", "[]", "{}", '{"path": null, "command": "x"}', '{"path": [[1, 2]]}'])
def test_what_is_no_record_is_a_value_error(line: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        Record.from_json(line)


@pytest.mark.parametrize(
    "record, is_failure",
    [
        (record_of(), False),
        (record_of(verified=None, contacts=None), False),
        (record_of(verified=False), True),
        (record_of(contacts=1), True),
        (record_of(Outcome.TIMEOUT), True),
        (record_of(Outcome.ERROR, verified=None, contacts=None), True),
    ],
)
def test_failing_is_no_success_or_not_verified_or_a_touch(record: Record, *, is_failure: bool) -> None:
    assert record.is_failure is is_failure
