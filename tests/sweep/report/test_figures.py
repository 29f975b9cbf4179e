from __future__ import annotations

import pytest

from robotcore.outcome import Outcome
from robotcore.sweep.agreement import agreements_of
from robotcore.sweep.report.groups import Spread, goal_of, groups_of, milestones_of
from robotcore.sweep.report.head import Head, ranges
from tests.sweep.report.samples import failed, passed


def test_runs_are_grouped_by_world_then_backend() -> None:
    records = [passed(), passed(world="clutter"), passed(backend="pybullet"), passed()]
    groups = groups_of(records)
    assert [(each.name, each.runs) for each in groups] == [
        ("arena · kinematic", 2),
        ("arena · pybullet", 1),
        ("clutter · kinematic", 1),
    ]


def test_a_world_has_a_colour_and_a_backend_its_dashes() -> None:
    records = [passed(world=world, backend=backend) for world in ("arena", "open") for backend in ("a", "b")]
    assert [each.style for each in groups_of(records)] == ["c0 d0", "c0 d1", "c1 d0", "c1 d1"]
    assert [each.style for each in groups_of(records[:2])] == ["c0 d0", "c1 d1"]


def test_a_run_that_broke_before_it_was_judged_counts_as_not_verified() -> None:
    (group,) = groups_of([passed(), failed(outcome=Outcome.ERROR, verified=None, contacts=None)])
    assert (group.successes, group.runs, group.failing, group.contacts) == (1, 2, 1, 0)


def test_the_simulators_word_counts_against_the_apps() -> None:
    (group,) = groups_of([passed(), passed(verified=False)])
    assert (group.successes, group.failing) == (1, 1)


def test_where_nobody_judges_the_apps_word_counts() -> None:
    (group,) = groups_of([passed(verified=None, contacts=None), failed(verified=None, contacts=None)])
    assert not group.is_judged
    assert (group.successes, group.contacts) == (1, None)


def test_contacts_are_added_up_and_touched_runs_fail() -> None:
    (group,) = groups_of([passed(contacts=2), passed(contacts=3), passed()])
    assert (group.contacts, group.failing, group.successes) == (5, 2, 3)


def test_times_are_of_passing_runs() -> None:
    records = [*(passed(sim_time_s=float(time)) for time in range(11)), failed(sim_time_s=120.0)]
    assert groups_of(records)[0].spread == Spread(1.0, 5.0, 9.0, 10.0)
    assert groups_of([failed()])[0].spread is None


def test_milestones_come_in_the_order_of_their_times() -> None:
    records = [passed(milestones={"c": 9.0, "a": 0.0}), passed(milestones={"a": 0.0, "b": 4.0})]
    assert milestones_of(groups_of(records)) == ["a", "b", "c"]


def test_the_goal_is_what_passing_runs_reach_last() -> None:
    groups = groups_of([passed(), passed(), failed(milestones={"lost": 90.0})])
    assert goal_of(groups, ["search", "seen", "arrived", "lost"]) == "arrived"
    assert goal_of(groups_of([failed()]), ["search"]) == "search"
    assert goal_of([], []) is None


def test_backends_are_compared_where_both_ran_the_same() -> None:
    records = [
        passed(seed=1),
        passed(seed=2),
        passed(seed=3),
        passed(seed=4),
        passed(seed=1, backend="pybullet"),
        failed(seed=2, backend="pybullet"),
        passed(seed=3, backend="pybullet", milestones={"seen": 1.0, "search": 2.0, "arrived": 9.0}),
        passed(seed=4, backend="pybullet", world="clutter"),
    ]
    (agreement,) = agreements_of(records)
    assert (len(agreement.pairs), agreement.same_outcome, agreement.same_milestones) == (3, 2, 1)
    assert [first.seed for first, _ in agreement.differing] == [2, 3]


def test_backends_that_share_no_run_are_not_compared() -> None:
    assert agreements_of([passed(seed=1), passed(seed=2, backend="pybullet")]) == []


@pytest.mark.parametrize(
    "numbers, told", [([], ""), ([4], "4"), ([3, 1, 2, 9, 7, 8, 8], "1–3, 7–9"), ([1, 3, 5], "1, 3, 5")]
)
def test_seeds_are_told_in_short(numbers: list[int], told: str) -> None:
    assert ranges(numbers) == told


def test_the_head_leaves_out_what_there_is_not() -> None:
    terms = [term for term, _ in Head.of([passed(world=None, seed=None)], asked="").facts]
    assert "Robot" in terms
    assert not {"Worlds", "Seeds"} & set(terms)


def test_times_add_up_in_hours_and_minutes() -> None:
    facts = dict(Head.of([passed(sim_time_s=1830.0), passed(sim_time_s=1831.0)], asked="").facts)
    assert facts["Robot's time"] == "1 h 1 min 1 s"
