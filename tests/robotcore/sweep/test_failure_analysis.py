"""Failure analysis: conditions that have a significant split, and conditions that have none."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import pytest

from robotcore.sweep import permutation_test
from robotcore.sweep.failure_analysis import SignificantSplit, explain
from robotcore.sweep.permutation_test import Share
from robotcore.sweep.record import Record
from tests.robotcore.sweep.report.samples import make_fail, make_pass
from tests.texts import CheckText


def make_record(*, fails: bool, **values: Any) -> Record:
    return (make_fail if fails else make_pass)(**values)


def run(*, fails: bool, **conditions: float | str) -> Record:
    return make_record(fails=fails, conditions=conditions)


def find_splits(records: Sequence[Record]) -> list[SignificantSplit]:
    return list(explain(records).splits)


def list_sides(records: Sequence[Record]) -> list[tuple[str, str, Share, Share]]:
    """Return the group, the side and the shares of each found."""
    return [(str(each.group), each.side, each.split.inside, each.split.outside) for each in find_splits(records)]


def runs_by_light(dark_failing: int, dark: int, bright_failing: int, bright: int) -> list[Record]:
    """Return dark runs, brightness 0.1 to 0.3, and bright runs, 0.4 to 1."""
    return [
        *(run(fails=at < dark_failing, light_brightness=0.1 + 0.2 * at / dark) for at in range(dark)),
        *(run(fails=at < bright_failing, light_brightness=1.0 - 0.6 * at / bright) for at in range(bright)),
    ]


ARENA = "in arena on kinematic"


def test_the_threshold_between_failing_and_passing_runs_is_reported(check_text: CheckText) -> None:
    records = runs_by_light(7, 12, 3, 188)
    (found,) = find_splits(records)
    assert found.condition == "light_brightness"
    assert found.p == 0.001
    records = [run(fails=at < 7, light=0.1) for at in range(12)] + [run(fails=at < 3, light=0.4) for at in range(188)]
    assert list_sides(records) == [(ARENA, "light < 0.2", Share(7, 12), Share(3, 188))]
    check_text("\n".join(explain(records).lines))


def test_the_side_above_a_threshold_is_reported_too() -> None:
    records = [run(fails=noise >= 9, camera_noise=noise) for noise in range(12)] * 4
    assert list_sides(records) == [(ARENA, "camera_noise ≥ 8.5", Share(12, 12), Share(0, 36))]


def test_a_word_is_reported_against_all_others() -> None:
    textures = ["wood"] * 20 + ["tiles"] * 20 + ["plain"] * 20
    records = [run(fails=floor == "wood" and at % 4 > 0, floor=floor) for at, floor in enumerate(textures)]
    assert list_sides(records) == [(ARENA, "floor = wood", Share(15, 20), Share(0, 40))]


def test_the_split_with_the_least_p_comes_first() -> None:
    records = [run(fails=at < 12, weak=at < 30, strong=at < 14) for at in range(100)]
    assert [each.condition for each in find_splits(records)] == ["strong", "weak"]


@pytest.mark.slow
def test_one_sweep_of_twenty_has_a_significant_split_by_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 300 sweeps, 15 have such a split on average. With a probability of 98 %, at most 23 sweeps have one."""
    monkeypatch.setattr(permutation_test, "SHUFFLES", 199)
    assert 4 <= sum(bool(find_splits(_fail_by_chance(random.Random(seed)))) for seed in range(300)) <= 23


@pytest.mark.slow
def test_backends_that_fail_with_the_same_seeds_give_no_more_splits_by_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the runs of both backends counted as independent, every second sweep would have a significant split."""
    monkeypatch.setattr(permutation_test, "SHUFFLES", 199)
    both = ("kinematic", "pybullet")
    assert sum(bool(find_splits(_fail_by_chance(random.Random(seed), both))) for seed in range(150)) <= 14


def _fail_by_chance(dice: random.Random, backends: Sequence[str] = ("kinematic",)) -> list[Record]:
    """Return runs that fail by chance. Runs with the same seed have the same conditions and outcome on all backends."""
    return [
        make_record(fails=fails, seed=seed, backend=backend, conditions=drawn)
        for seed in range(40)
        for fails in [dice.random() < 0.2]
        for drawn in [{f"condition_{index}": dice.random() for index in range(4)}]
        for backend in backends
    ]


def test_a_clear_cause_is_found_among_many_conditions() -> None:
    """Of 60 runs 12 fail, among them all 6 dark runs. Fisher's p-value is 2e-5, and 3000 splits are tried."""
    dice = random.Random(3)
    dark = [0.1 + 0.025 * at for at in range(6)]
    bright = [0.3 + 0.01 * at for at in range(54)]
    records = [
        run(fails=light < 0.27 or at % 9 == 8, light=light, **{f"other_{index}": dice.random() for index in range(27)})
        for at, light in enumerate([*dark, *bright], start=-6)
    ]
    (found,) = find_splits(records)
    assert (found.side, found.split.inside, found.split.outside) == ("light < 0.3", Share(6, 6), Share(6, 54))
    assert found.p == pytest.approx(0.01, abs=0.01)


def test_the_order_in_which_runs_end_changes_nothing() -> None:
    dice = random.Random(1)
    records = [
        make_record(fails=dice.random() < 0.3, seed=seed, backend=backend, conditions={"light": dice.random()})
        for seed in range(40)
        for backend in ("kinematic", "pybullet")
    ]
    lines = explain(records).lines
    dice.shuffle(records)
    assert explain(records).lines == lines


def test_a_world_that_is_both_dark_and_hard_does_not_make_darkness_a_cause() -> None:
    dice = random.Random(1)
    worlds = {"cellar": (0.5, 0.1, 0.4), "garden": (0.02, 0.5, 1.0)}
    records = [
        make_record(fails=dice.random() < risk, world=world, conditions={"light": dice.uniform(dark, bright)})
        for world, (risk, dark, bright) in worlds.items()
        for _ in range(100)
    ]
    assert find_splits(records) == []


@pytest.mark.parametrize(
    "world, group", [("clutter", "in clutter on pybullet"), (None, "on pybullet")], ids=["in a world", "in none"]
)
def test_a_split_is_of_one_world_and_one_backend(world: str | None, group: str) -> None:
    dark = [
        make_record(fails=at < 8, world=world, backend="pybullet", conditions={"light": at // 8}) for at in range(30)
    ]
    other = [run(fails=False, light=at // 8) for at in range(30)]
    assert list_sides(dark + other) == [(group, "light < 0.5", Share(8, 8), Share(0, 22))]


def test_a_split_among_few_conditions_may_be_insignificant_among_many() -> None:
    dice = random.Random(0)
    alone = [run(fails=at < 5, light=at < 12) for at in range(40)]
    noisy = [
        run(fails=at < 5, light=at < 12, **{f"noise_{index}": dice.random() for index in range(20)}) for at in range(40)
    ]
    assert [each.condition for each in find_splits(alone)] == ["light"]
    assert find_splits(noisy) == []


def test_a_run_without_conditions_does_not_count() -> None:
    records = [run(fails=at < 8, light=at < 8) for at in range(30)] + [make_fail() for _ in range(9)]
    assert list_sides(records) == [(ARENA, "light ≥ 0.5", Share(8, 8), Share(0, 22))]


def test_a_condition_that_never_changes_is_no_cause() -> None:
    assert find_splits([run(fails=at < 5, light=1.0, floor="wood") for at in range(20)]) == []
    assert find_splits([]) == []


def test_a_line_has_the_p_of_its_split(check_text: CheckText) -> None:
    records = [run(fails=at < 12, light=at) for at in range(48)]
    check_text("\n".join(explain(records).lines))
    assert explain(records).reason == ""


def test_without_a_significant_split_the_best_split_is_reported(check_text: CheckText) -> None:
    records = [run(fails=at in (0, 1, 9), light=at) for at in range(12)]
    check_text("\n".join(explain(records).lines))


@pytest.mark.parametrize(
    "records",
    [
        [run(fails=True, light=at) for at in range(9)],
        [make_record(fails=at < 5, world="pit" if at < 5 else "open", conditions={"light": at}) for at in range(9)],
        [run(fails=at < 5, light=1) for at in range(9)],
        [run(fails=at < 1, light=at) for at in range(19)],
        [run(fails=False, light=at) for at in range(9)],
        [make_fail(), make_pass()],
        [],
    ],
    ids=["all failed", "all or none", "all alike", "too few", "none failed", "no conditions", "no runs"],
)
def test_the_reason_for_no_significant_split_is_reported(records: Sequence[Record], check_text: CheckText) -> None:
    check_text(explain(records).reason)
    assert explain(records).splits == ()


def test_a_big_sweep_without_a_cause_has_no_significant_split(check_text: CheckText) -> None:
    """A float cannot hold the number of ways in which so many runs fail."""
    dice = random.Random(1)
    records = [run(fails=at < 300, light=dice.random()) for at in range(3600)]
    assert explain(records).splits == ()
    check_text(explain(records).reason)
