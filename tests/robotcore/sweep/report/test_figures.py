from __future__ import annotations

from pathlib import Path

from robotcore.runtime.result import Outcome
from robotcore.sweep.report.failures import MAX_ENDINGS, count_endings
from robotcore.sweep.report.page import Head
from robotcore.sweep.report.series import find_goal, list_milestones, make_series
from robotcore.sweep.statistics import compare_backends, group_records
from tests.robotcore.sweep.report.samples import failed, passed


def test_runs_are_grouped_by_world_then_backend() -> None:
    records = [passed(), passed(world="clutter"), passed(backend="pybullet"), passed()]
    series = make_series(records)
    assert [(each.group.name, each.group.runs) for each in series] == [
        ("arena · kinematic", 2),
        ("arena · pybullet", 1),
        ("clutter · kinematic", 1),
    ]


def test_a_world_has_a_colour_and_a_backend_its_dashes() -> None:
    records = [passed(world=world, backend=backend) for world in ("arena", "open") for backend in ("a", "b")]
    assert [each.style for each in make_series(records)] == ["c0 d0", "c0 d1", "c1 d0", "c1 d1"]
    assert [each.style for each in make_series(records[:2])] == ["c0 d0", "c1 d1"]


def test_the_figures_of_the_page_are_those_of_the_table() -> None:
    records = [passed(), passed(contacts=3), failed(), failed(outcome=Outcome.ERROR, verified=None, contacts=None)]
    assert [each.group for each in make_series(records)] == group_records(records)


def test_milestones_come_in_the_order_of_their_times() -> None:
    records = [passed(milestones={"c": 9.0, "a": 0.0}), passed(milestones={"a": 0.0, "b": 4.0})]
    assert list_milestones(make_series(records)) == ["a", "b", "c"]


def test_the_goal_is_what_passing_runs_reach_last() -> None:
    series = make_series([passed(), passed(), failed(milestones={"lost": 90.0})])
    assert find_goal(series, ["search", "seen", "arrived", "lost"]) == "arrived"
    lost = make_series([failed(milestones={"search": 0.0, "seen": 3.0})])
    assert find_goal(lost, ["search", "seen"]) == "seen"


def test_there_is_no_goal_where_no_run_gets_anywhere() -> None:
    assert find_goal(make_series([failed(milestones={"search": 0.0})]), ["search"]) is None
    assert find_goal([], []) is None


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
    (agreement,) = compare_backends(records)
    assert (len(agreement.pairs), agreement.same_outcome, agreement.same_milestones) == (3, 2, 1)
    assert [first.seed for first, _ in agreement.differing] == [2, 3]


def test_backends_that_share_no_run_are_not_compared() -> None:
    assert compare_backends([passed(seed=1), passed(seed=2, backend="pybullet")]) == []


def test_seeds_are_reported_as_they_are_written() -> None:
    head = Head.of([passed(seed=seed) for seed in (3, 1, 2, 9, 7, 8, 8)], command="", folder=Path("here"))
    assert dict(head.facts)["Seeds"] == "1-3,7-9"


def test_the_head_leaves_out_what_there_is_not() -> None:
    terms = [term for term, _ in Head.of([passed(world=None, seed=None)], command="", folder=Path("here")).facts]
    assert "Robot" in terms
    assert not {"Worlds", "Seeds"} & set(terms)


def test_times_add_up_in_hours_and_minutes() -> None:
    facts = dict(Head.of([passed(sim_time_s=1830.0), passed(sim_time_s=1831.0)], command="", folder=Path("here")).facts)
    assert facts["Robot's time"] == "1 h 1 min 1 s"


def test_the_ways_to_fail_are_named_by_their_number_and_place() -> None:
    records = [
        *(failed(reason="late", seed=seed) for seed in (1, 2)),
        failed(reason="late", world="clutter"),
        passed(contacts=1),
        passed(contacts=7),
        passed(),
    ]
    assert count_endings(make_series(records)) == [("timeout, late", 3, (2, 1)), ("contact", 2, (2, 0))]


def test_ways_to_fail_that_are_all_different_are_reported_as_one() -> None:
    records = [failed(reason=f"lost at {at} m") for at in range(20)] + [failed(reason="late")] * 2
    endings = count_endings(make_series(records))
    assert endings[0] == ("timeout, late", 2, (2,))
    assert endings[MAX_ENDINGS:] == [("in 9 other ways", 9, (9,))]
    assert count_endings(make_series(records[: MAX_ENDINGS + 1]))[MAX_ENDINGS:] == [("in 1 other way", 1, (1,))]
