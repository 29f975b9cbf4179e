from __future__ import annotations

from pathlib import Path

from robotcore.runtime.result import Outcome
from robotcore.sweep.report.failures import MAX_ENDINGS, count_endings
from robotcore.sweep.report.page import Head
from robotcore.sweep.report.series import find_goal, list_milestones, make_series
from robotcore.sweep.statistics import compare_backends, group_records
from tests.robotcore.sweep.report.samples import make_fail, make_pass


def test_runs_are_grouped_by_world_then_backend() -> None:
    records = [make_pass(), make_pass(world="clutter"), make_pass(backend="pybullet"), make_pass()]
    series = make_series(records)
    assert [(each.group.name, each.group.runs) for each in series] == [
        ("arena · kinematic", 2),
        ("arena · pybullet", 1),
        ("clutter · kinematic", 1),
    ]


def test_a_world_has_a_colour_and_a_backend_its_dashes() -> None:
    records = [make_pass(world=world, backend=backend) for world in ("arena", "open") for backend in ("a", "b")]
    assert [each.style for each in make_series(records)] == ["c0 d0", "c0 d1", "c1 d0", "c1 d1"]
    assert [each.style for each in make_series(records[:2])] == ["c0 d0", "c1 d1"]


def test_the_groups_of_the_page_are_those_of_the_table() -> None:
    records = [
        make_pass(),
        make_pass(contacts=3),
        make_fail(),
        make_fail(outcome=Outcome.ERROR, verified=None, contacts=None),
    ]
    assert [each.group for each in make_series(records)] == group_records(records)


def test_milestones_come_in_the_order_of_their_times() -> None:
    records = [make_pass(milestones={"c": 9.0, "a": 0.0}), make_pass(milestones={"a": 0.0, "b": 4.0})]
    assert list_milestones(make_series(records)) == ["a", "b", "c"]


def test_the_goal_is_the_last_milestone_of_passing_runs() -> None:
    series = make_series([make_pass(), make_pass(), make_fail(milestones={"lost": 90.0})])
    assert find_goal(series, ["search", "seen", "arrived", "lost"]) == "arrived"
    lost = make_series([make_fail(milestones={"search": 0.0, "seen": 3.0})])
    assert find_goal(lost, ["search", "seen"]) == "seen"


def test_there_is_no_goal_if_no_run_reaches_a_milestone_after_0_s() -> None:
    assert find_goal(make_series([make_fail(milestones={"search": 0.0})]), ["search"]) is None
    assert find_goal([], []) is None


def test_backends_are_compared_by_the_runs_that_both_have() -> None:
    records = [
        make_pass(seed=1),
        make_pass(seed=2),
        make_pass(seed=3),
        make_pass(seed=4),
        make_pass(seed=1, backend="pybullet"),
        make_fail(seed=2, backend="pybullet"),
        make_pass(seed=3, backend="pybullet", milestones={"seen": 1.0, "search": 2.0, "arrived": 9.0}),
        make_pass(seed=4, backend="pybullet", world="clutter"),
    ]
    (agreement,) = compare_backends(records)
    assert (len(agreement.pairs), agreement.same_outcome, agreement.same_milestones) == (3, 2, 1)
    assert [first.seed for first, _ in agreement.differing] == [2, 3]


def test_backends_that_share_no_run_are_not_compared() -> None:
    assert compare_backends([make_pass(seed=1), make_pass(seed=2, backend="pybullet")]) == []


def test_the_head_has_the_seeds_as_ranges() -> None:
    head = Head.of([make_pass(seed=seed) for seed in (3, 1, 2, 9, 7, 8, 8)], command="", folder=Path("here"))
    assert dict(head.facts)["Seeds"] == "1-3,7-9"


def test_the_head_leaves_out_empty_facts() -> None:
    terms = [term for term, _ in Head.of([make_pass(world=None, seed=None)], command="", folder=Path("here")).facts]
    assert "Robot" in terms
    assert not {"Worlds", "Seeds"} & set(terms)


def test_times_add_up_in_hours_and_minutes() -> None:
    facts = dict(
        Head.of([make_pass(sim_time_s=1830.0), make_pass(sim_time_s=1831.0)], command="", folder=Path("here")).facts
    )
    assert facts["Robot's time"] == "1 h 1 min 1 s"


def test_endings_are_counted_by_group() -> None:
    records = [
        *(make_fail(reason="late", seed=seed) for seed in (1, 2)),
        make_fail(reason="late", world="clutter"),
        make_pass(contacts=1),
        make_pass(contacts=7),
        make_pass(),
    ]
    assert count_endings(make_series(records)) == [("timeout, late", 3, (2, 1)), ("contact", 2, (2, 0))]


def test_rare_endings_are_one_row() -> None:
    records = [make_fail(reason=f"lost at {at} m") for at in range(20)] + [make_fail(reason="late")] * 2
    endings = count_endings(make_series(records))
    assert endings[0] == ("timeout, late", 2, (2,))
    assert endings[MAX_ENDINGS:] == [("in 9 other ways", 9, (9,))]
    assert count_endings(make_series(records[: MAX_ENDINGS + 1]))[MAX_ENDINGS:] == [("in 1 other way", 1, (1,))]
