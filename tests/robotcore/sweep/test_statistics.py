"""Statistics of groups, and requirements."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robotcore import Outcome
from robotcore.errors import UsageError
from robotcore.sweep import Record
from robotcore.sweep.statistics import Group, Requirement, group_records, list_missed, wilson
from tests.robotcore.sweep.conftest import record_of
from tests.texts import Raises

HUNG = record_of(Outcome.ERROR, verified=None, contacts=None, time=0.0)
"""A run that was given up, or whose process died."""

GOOD = Group("kinematic", "arena", 100, 3, 99, 97, 0, 0, 30.0, 60.0, 90.0)
BAD = Group("kinematic", "open", 100, 4, 90, 96, 1, 0, 31.0, 61.0, 91.0)
DARK = Group("kinematic", "lab", 100, 0, 100, None, None, 100, 3.0, 6.0, 9.0)


@pytest.mark.parametrize(
    "successes, n, low, high",
    [(0, 10, 0.0, 0.2775), (10, 10, 0.7225, 1.0), (5, 10, 0.2366, 0.7634), (81, 263, 0.2553, 0.3662), (0, 0, 0.0, 1.0)],
)
def test_wilson_interval_is_that_of_the_literature(successes: int, n: int, low: float, high: float) -> None:
    assert wilson(successes, n) == pytest.approx((low, high), abs=5e-5)


def test_runs_are_added_up_by_backend_and_world() -> None:
    records = [
        record_of(world="open", time=4.0),
        record_of(world="open", time=2.0, contacts=3),
        record_of(Outcome.TIMEOUT, verified=False, world="open", time=9.0),
        record_of(world="arena", time=1.0),
    ]
    arena, sparse = group_records(records)
    assert (arena.name, arena.runs, arena.failing) == ("arena · kinematic", 1, 0)
    assert (sparse.name, sparse.runs, sparse.failing) == ("open · kinematic", 3, 2)
    assert (sparse.successes, sparse.verified, sparse.contacts, sparse.contacts_unknown) == (2, 2, 3, 0)


def test_a_run_that_nobody_judged_does_not_count_as_verified() -> None:
    (group,) = group_records([record_of(), HUNG])
    assert (group.verified, group.runs, group.verified_share) == (1, 2, 0.5)
    assert group.verified_95 == wilson(1, 2)


def test_a_run_that_broke_before_its_contacts_were_reported_may_have_touched_anything() -> None:
    (group,) = group_records([record_of(contacts=2), HUNG])
    assert (group.contacts, group.contacts_unknown) == (2, 1)


def test_what_no_run_could_tell_is_unknown() -> None:
    (group,) = group_records([record_of(verified=None, contacts=None)])
    assert (group.verified, group.contacts, group.verified_share, group.verified_95) == (None, None, None, None)


def test_the_simulators_word_counts_against_the_apps() -> None:
    (group,) = group_records([record_of(), record_of(verified=False)])
    assert (group.successes, group.verified, group.verified_share) == (2, 1, 0.5)


def test_times_say_within_how_long_half_90_percent_and_all_runs_pass() -> None:
    (group,) = group_records(record_of(time=float(time)) for time in range(1, 21))
    assert (group.median_time_s, group.p90_time_s, group.slowest_time_s) == (10.5, 18.0, 20.0)


@pytest.mark.parametrize(
    "failing, median, slow, slowest",
    [(1, 5.0, 5.0, None), (2, 5.0, None, None), (5, 5.0, None, None), (6, None, None, None)],
)
@pytest.mark.parametrize("how", [HUNG, record_of(Outcome.FAILURE, time=0.1), record_of(contacts=1, time=0.1)])
def test_a_run_that_fails_at_once_makes_no_group_faster(
    how: Record, failing: int, median: float | None, slow: float | None, slowest: float | None
) -> None:
    (group,) = group_records([how] * failing + [record_of(time=5.0)] * (10 - failing))
    assert (group.median_time_s, group.p90_time_s, group.slowest_time_s) == (median, slow, slowest)


@pytest.mark.parametrize(
    "text", ["verified>=0.97", "success >= 0.95", "contacts<=0", "median_time_s<=30.5", "slowest_time_s<=90"]
)
def test_a_bound_is_kept_at_it_and_missed_beyond(text: str) -> None:
    requirement = Requirement.parse(text)
    assert requirement.is_met_by(GOOD)
    assert not requirement.is_met_by(BAD)


def test_what_nobody_knows_keeps_no_bound() -> None:
    assert list_missed([Requirement.parse("verified>=0"), Requirement.parse("contacts<=9")], [DARK]) == [
        "kinematic, lab: verified is unknown, required verified>=0",
        "kinematic, lab: contacts is unknown, required contacts<=9",
    ]


def test_a_miss_by_little_can_be_seen() -> None:
    group = replace(GOOD, runs=100_000, verified=99_996, contacts=12_345)
    requirements = [Requirement.parse("verified>=0.99997"), Requirement.parse("contacts<=12344")]
    assert list_missed(requirements, [group]) == [
        "kinematic, arena: verified is 0.99996, required verified>=0.99997",
        "kinematic, arena: contacts is 12345, required contacts<=12344",
    ]


@pytest.mark.parametrize(
    "text, got",
    [("contacts<=0", "unknown"), ("median_time_s<=120", "never"), ("slowest_time_s<=120", "never")],
)
def test_runs_that_hung_open_no_gate(text: str, got: str) -> None:
    hung = record_of(Outcome.ERROR, verified=None, contacts=None, time=0.0)
    requirement = Requirement.parse(text)
    assert list_missed([requirement], group_records([record_of(), hung, hung])) == [
        f"kinematic, open: {requirement.measure} is {got}, required {text}"
    ]


def test_each_group_that_misses_has_its_line() -> None:
    assert list_missed([Requirement.parse("verified>=0.97")], [GOOD, BAD]) == [
        "kinematic, open: verified is 0.96, required verified>=0.97"
    ]


@pytest.mark.parametrize(
    "text, kind",
    [
        ("verified", "bad-requirement"),
        ("verified>0.9", "bad-requirement"),
        ("verified==1", "bad-requirement"),
        ("verrified>=0.9", "unknown-measure"),
        ("verified>=97", "bound-out-of-range"),
        ("verified>=97%", "bad-bound"),
        ("verified>=nan", "bound-out-of-range"),
        ("contacts<=-1", "bound-out-of-range"),
        ("contacts<=nan", "bound-out-of-range"),
        ("median_time_s<=inf", "bound-out-of-range"),
        ("slowest_time_s<=1e999", "bound-out-of-range"),
    ],
)
def test_a_wrong_expression_is_answered_with_the_right_form(text: str, kind: str, raises: Raises) -> None:
    with raises(UsageError, kind, text=text):
        Requirement.parse(text)
