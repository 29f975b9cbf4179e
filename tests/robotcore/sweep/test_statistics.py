from __future__ import annotations

import pytest

from robotcore import Outcome
from robotcore.sweep import Record
from robotcore.sweep.statistics import grouped, wilson
from tests.robotcore.sweep.conftest import record_of

HUNG = record_of(Outcome.ERROR, verified=None, contacts=None, time=0.0)
"""A run that was given up, or whose process died."""


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
    arena, sparse = grouped(records)
    assert (arena.name, arena.runs, arena.failing) == ("arena · kinematic", 1, 0)
    assert (sparse.name, sparse.runs, sparse.failing) == ("open · kinematic", 3, 2)
    assert (sparse.successes, sparse.verified, sparse.contacts, sparse.untold) == (2, 2, 3, 0)


def test_a_run_that_nobody_judged_does_not_count_as_verified() -> None:
    (group,) = grouped([record_of(), HUNG])
    assert (group.verified, group.runs, group.verified_share) == (1, 2, 0.5)
    assert group.verified_95 == wilson(1, 2)


def test_a_run_that_broke_before_its_contacts_were_told_may_have_touched_anything() -> None:
    (group,) = grouped([record_of(contacts=2), HUNG])
    assert (group.contacts, group.untold) == (2, 1)


def test_what_no_run_could_tell_is_unknown() -> None:
    (group,) = grouped([record_of(verified=None, contacts=None)])
    assert (group.verified, group.contacts, group.verified_share, group.verified_95) == (None, None, None, None)


def test_the_simulators_word_counts_against_the_apps() -> None:
    (group,) = grouped([record_of(), record_of(verified=False)])
    assert (group.successes, group.verified, group.verified_share) == (2, 1, 0.5)


def test_times_say_within_how_long_half_90_percent_and_all_runs_pass() -> None:
    (group,) = grouped(record_of(time=float(time)) for time in range(1, 21))
    assert (group.median_time_s, group.p90_time_s, group.slowest_time_s) == (10.5, 18.0, 20.0)


@pytest.mark.parametrize(
    "failing, median, slow, slowest",
    [(1, 5.0, 5.0, None), (2, 5.0, None, None), (5, 5.0, None, None), (6, None, None, None)],
)
@pytest.mark.parametrize("how", [HUNG, record_of(Outcome.FAILURE, time=0.1), record_of(contacts=1, time=0.1)])
def test_a_run_that_fails_at_once_makes_no_group_faster(
    how: Record, failing: int, median: float | None, slow: float | None, slowest: float | None
) -> None:
    (group,) = grouped([how] * failing + [record_of(time=5.0)] * (10 - failing))
    assert (group.median_time_s, group.p90_time_s, group.slowest_time_s) == (median, slow, slowest)
