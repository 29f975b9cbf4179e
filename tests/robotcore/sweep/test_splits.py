from __future__ import annotations

import random

import numpy as np

from robotcore.sweep.splits import MAX_THRESHOLDS, Share, Splits


def sides(splits: Splits) -> list[tuple[str, float | str]]:
    return [side[:2] for side in splits.sides]


def test_numbers_are_split_between_neighbours_on_both_sides() -> None:
    splits = Splits.of([0.4, 0.1, 0.1, 0.2])
    assert sides(splits) == [("<", 0.2), ("≥", 0.2), ("<", 0.3), ("≥", 0.3)]
    assert splits.sizes.tolist() == [2, 2, 3, 1]


def test_a_word_is_split_from_all_others() -> None:
    splits = Splits.of(["wood", "tiles", "wood", "grass"])
    assert sides(splits) == [("=", "grass"), ("=", "tiles"), ("=", "wood")]
    assert splits.sizes.tolist() == [1, 1, 2]


def test_words_among_numbers_make_all_of_them_words() -> None:
    assert sides(Splits.of([0.5, "auto"])) == [("=", "0.5"), ("=", "auto")]


def test_what_never_changes_has_no_split() -> None:
    assert Splits.of([1.0, 1.0]).sides == Splits.of(["wood", "wood"]).sides == ()


def test_runs_are_counted_on_each_side() -> None:
    splits = Splits.of([0.4, 0.1, 0.1, 0.2])
    assert splits.inside(np.array([[1, 3], [0, 3]])).tolist() == [[1, 1, 2, 0], [0, 2, 1, 1]]


def test_a_split_has_the_shares_of_both_its_sides() -> None:
    split = Splits.of([0.4, 0.1, 0.1, 0.2]).split(2, np.array([1, 3]))
    assert split == ("<", 0.3, Share(2, 3), Share(0, 1))


def test_counts_are_those_of_looking_at_every_run() -> None:
    dice = random.Random(1)
    values = [dice.random() for _ in range(500)]
    runs = np.array([dice.sample(range(500), 40) for _ in range(3)])
    splits = Splits.of(values)
    assert len(splits.sides) == 2 * MAX_THRESHOLDS
    for row, counts in zip(runs.tolist(), splits.inside(runs).tolist(), strict=True):
        below = [sum(values[run] < float(side.value) for run in row) for side in splits.sides[::2]]
        assert counts[::2] == below
        assert counts[1::2] == [40 - count for count in below]
