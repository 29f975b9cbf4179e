from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from robotcore import Outcome
from robotcore.sweep import Record
from tests.robotcore.sweep.conftest import make_record


@pytest.mark.parametrize("path", [None, (), ((0.0, 1.0, 2.0), (0.5, 1.0, 2.1))])
def test_json_holds_a_complete_record(path: tuple[tuple[float, float, float], ...] | None) -> None:
    record = replace(make_record(), path=path, picture="failures/a.png")
    assert Record.from_json(record.to_json()) == record


def test_nan_becomes_null_and_its_points_are_left_out() -> None:
    record = replace(make_record(), path=((0.0, 1.0, 2.0), (0.5, math.nan, 2.0), (1.0, 1.0, math.inf)))
    record = replace(record, result=replace(record.result, distance_to_target_m=math.nan))
    payload = json.loads(record.to_json(), parse_constant=pytest.fail)
    assert (payload["path"], payload["distance_to_target_m"]) == ([[0.0, 1.0, 2.0]], None)


def _make_line(**changes: object) -> str:
    return json.dumps({**json.loads(make_record().to_json()), **changes})


@pytest.mark.parametrize(
    "line",
    [
        pytest.param("", id="empty"),
        pytest.param('{"app": "green-se', id="torn"),
        pytest.param(b'{"app": "caf\xe9"}\n', id="no Unicode"),
        pytest.param("[]", id="no object"),
        pytest.param("{}", id="no keys"),
        pytest.param(_make_line(verified="maybe"), id="verified maybe"),
        pytest.param(_make_line(seed="3"), id="seed text"),
        pytest.param(_make_line(sim_time_s=math.nan), id="time nan"),
        pytest.param(_make_line(path=[[1, 2]]), id="short point"),
    ],
)
def test_a_line_that_is_no_record_is_refused(line: str | bytes) -> None:
    with pytest.raises(ValueError, match="it is not the record of a run"):
        Record.from_json(line)


def test_a_character_that_is_no_unicode_is_written_as_an_escape() -> None:
    assert Record.from_json(make_record(reason="no caf\udce9 \U0001f600").to_json()).result.reason == (
        "no caf\\udce9 \U0001f600"
    )


@pytest.mark.parametrize(
    "record, is_failure",
    [
        (make_record(), False),
        (make_record(verified=None, contacts=None), False),
        (make_record(verified=False), True),
        (make_record(contacts=1), True),
        (make_record(Outcome.TIMEOUT), True),
        (make_record(Outcome.ERROR, verified=None, contacts=None), True),
    ],
)
def test_a_run_fails_by_its_outcome_its_judge_or_its_contacts(record: Record, *, is_failure: bool) -> None:
    assert record.is_failure is is_failure
