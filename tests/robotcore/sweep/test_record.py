from __future__ import annotations

import json
import math
import re
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
    payload = json.loads(record.to_json(), parse_constant=pytest.fail)
    assert (payload["path"], payload["distance_to_target_m"]) == ([[0.0, 1.0, 2.0]], None)


def _line(**changes: object) -> str:
    return json.dumps({**json.loads(record_of().to_json()), **changes})


def _line_without(key: str) -> str:
    return json.dumps({name: value for name, value in json.loads(_line()).items() if name != key})


@pytest.mark.parametrize(
    "line, fault",
    [
        ("", "the line is empty"),
        ('{"app": "green-se', "it is no JSON from column 17 on"),
        ('{"app": "green-search", "bac": 1,\n', "it is no JSON from column 33 on"),
        (b'{"app": "caf\xe9"}\n', "it is no JSON from column 13 on"),
        ("[]", "it is no JSON object"),
        ("{}", "app is missing"),
        (_line_without("path"), "path is missing"),
        (_line(verified="maybe"), "verified should be true or false, got 'maybe'"),
        (_line(verified=1), "verified should be true or false, got 1"),
        (_line(seed="3"), "seed should be a whole number, got '3'"),
        (_line(sim_time_s=math.nan), "sim_time_s should be a finite number, got nan"),
        (_line(path=[[1, 2]]), "path[#1][#3] is missing"),
        (_line(milestones={"seen": None}), "milestones.seen should be a valid number, got nothing"),
        (
            _line(outcome="won"),
            "outcome should be 'success', 'failure', 'timeout', 'stopped', 'interrupted' or 'error', got 'won'",
        ),
    ],
)
def test_what_is_no_record_is_reported_in_plain_words(line: str | bytes, fault: str) -> None:
    with pytest.raises(ValueError, match=f"^no record of a run: {re.escape(fault)}$"):
        Record.from_json(line)


def test_a_reason_that_is_no_unicode_is_kept_with_its_bytes() -> None:
    assert Record.from_json(record_of(reason="no caf\udce9 \U0001f600").to_json()).result.reason == (
        "no caf\\udce9 \U0001f600"
    )


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
