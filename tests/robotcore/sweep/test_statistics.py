"""Statistics of groups, and requirements."""

from __future__ import annotations

from itertools import product

import pytest

from robotcore import Outcome
from robotcore.errors import UsageError
from robotcore.sweep.statistics import (
    Group,
    Requirement,
    group_records,
    list_missed_requirements,
    wilson,
)
from tests.robotcore.sweep.conftest import make_record
from tests.texts import CheckText, Raises

HUNG = make_record(Outcome.ERROR, verified=None, contacts=None, time=0.0)
"""The record of a run that hung, or whose process died."""

GOOD = Group("kinematic", "arena", 100, 3, 99, 97, 0, 0, 30.0, 60.0, 90.0)
BAD = Group("kinematic", "open", 100, 4, 90, 96, 1, 0, 31.0, 61.0, 91.0)
DARK = Group("kinematic", "lab", 100, 0, 100, None, None, 100, 3.0, 6.0, 9.0)


@pytest.mark.parametrize(
    "successes, n, low, high",
    [(0, 10, 0.0, 0.2775), (10, 10, 0.7225, 1.0), (5, 10, 0.2366, 0.7634), (81, 263, 0.2553, 0.3662), (0, 0, 0.0, 1.0)],
)
def test_the_wilson_interval_has_the_values_of_the_literature(successes: int, n: int, low: float, high: float) -> None:
    assert wilson(successes, n) == pytest.approx((low, high), abs=5e-5)


def test_runs_are_counted_by_backend_and_world() -> None:
    records = [
        make_record(world="open", time=4.0),
        make_record(world="open", time=2.0, contacts=3),
        make_record(Outcome.TIMEOUT, verified=False, world="open", time=9.0),
        make_record(world="arena", time=1.0),
    ]
    arena, unjudged, sparse = group_records([*records, make_record(world="lab", verified=None, contacts=None)])
    assert (arena.name, arena.runs, arena.failing) == ("arena · kinematic", 1, 0)
    assert (sparse.name, sparse.runs, sparse.failing) == ("open · kinematic", 3, 2)
    assert (sparse.successes, sparse.verified, sparse.contacts, sparse.contacts_unknown) == (2, 2, 3, 0)
    assert (unjudged.verified, unjudged.contacts, unjudged.verified_share, unjudged.verified_95) == (None,) * 4


def test_an_early_failure_does_not_make_a_group_faster() -> None:
    early = HUNG, make_record(Outcome.FAILURE, time=0.1), make_record(contacts=1, time=0.1)
    times = {1: (5.0, 5.0, None), 2: (5.0, None, None), 5: (5.0, None, None), 6: (None, None, None)}
    for record, (failing, expected) in product(early, times.items()):
        (group,) = group_records([record] * failing + [make_record(time=5.0)] * (10 - failing))
        assert (group.median_time_s, group.p90_time_s, group.slowest_time_s) == expected, (record, failing)


@pytest.mark.parametrize(
    "text", ["verified>=0.97", "success >= 0.95", "contacts<=0", "median_time_s<=30.5", "slowest_time_s<=90"]
)
def test_a_value_equal_to_the_bound_meets_it(text: str) -> None:
    requirement = Requirement.parse(text)
    assert requirement.is_met_by(GOOD)
    assert not requirement.is_met_by(BAD)


def test_an_unknown_value_meets_no_bound(check_text: CheckText) -> None:
    requirements = [Requirement.parse("verified>=0"), Requirement.parse("contacts<=9")]
    assert not any(each.is_met_by(DARK) for each in requirements)
    check_text("\n".join(list_missed_requirements(requirements, [DARK])))


@pytest.mark.parametrize(
    "text", ["verified>0.9", "verrified>=0.9", "verified>=97", "verified>=97%", "contacts<=-1", "median_time_s<=inf"]
)
def test_a_text_that_is_no_requirement_is_refused(text: str, raises: Raises) -> None:
    with raises(UsageError, "bad-requirement", text=text):
        Requirement.parse(text)
