from __future__ import annotations

import pytest

from robotcore import Outcome
from robotcore.sweep.statistics import Group, grouped, wilson
from tests.sweep.conftest import record_of


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
    assert grouped(records) == [
        Group("kinematic", "arena", 1, 1, 1, 0, 1.0, 1.0),
        Group("kinematic", "open", 3, 2, 2, 3, 4.0, 9.0),
    ]


def test_a_run_that_nobody_judged_does_not_count_as_verified() -> None:
    (group,) = grouped([record_of(), record_of(Outcome.ERROR, verified=None, contacts=None)])
    assert (group.verified, group.runs, group.contacts, group.verified_share) == (1, 2, 0, 0.5)


def test_what_no_run_could_tell_is_unknown() -> None:
    (group,) = grouped([record_of(verified=None, contacts=None)])
    assert (group.verified, group.contacts, group.verified_share, group.verified_95) == (None, None, None, None)
