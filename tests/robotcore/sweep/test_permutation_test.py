"""Splits of a condition, and Fisher's exact test."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from robotcore.sweep.permutation_test import MAX_THRESHOLDS, Share, Splits, compute_log_tails


def list_sides(splits: Splits) -> list[tuple[str, float | str]]:
    return [side[:2] for side in splits.sides]


def test_numbers_are_split_between_neighbours_on_both_sides() -> None:
    splits = Splits.of([0.4, 0.1, 0.1, 0.2])
    assert list_sides(splits) == [("<", 0.2), ("≥", 0.2), ("<", 0.3), ("≥", 0.3)]
    assert splits.sizes.tolist() == [2, 2, 3, 1]


def test_a_word_is_split_from_all_others() -> None:
    splits = Splits.of(["wood", "tiles", "wood", "grass"])
    assert list_sides(splits) == [("=", "grass"), ("=", "tiles"), ("=", "wood")]
    assert splits.sizes.tolist() == [1, 1, 2]


def test_a_word_among_numbers_makes_all_of_them_words() -> None:
    assert list_sides(Splits.of([0.5, "auto"])) == [("=", "0.5"), ("=", "auto")]


def test_a_condition_that_never_changes_has_no_split() -> None:
    assert Splits.of([1.0, 1.0]).sides == Splits.of(["wood", "wood"]).sides == ()


def test_runs_are_counted_on_each_side() -> None:
    splits = Splits.of([0.4, 0.1, 0.1, 0.2])
    assert splits.count_inside(np.array([[1, 3], [0, 3]])).tolist() == [[1, 1, 2, 0], [0, 2, 1, 1]]


def test_a_split_has_the_shares_of_both_its_sides() -> None:
    split = Splits.of([0.4, 0.1, 0.1, 0.2]).build_split(2, np.array([1, 3]))
    assert split == ("<", 0.3, Share(2, 3), Share(0, 1))


def test_counts_are_those_of_a_loop_over_all_runs() -> None:
    dice = random.Random(1)
    values = [dice.random() for _ in range(500)]
    runs = np.array([dice.sample(range(500), 40) for _ in range(3)])
    splits = Splits.of(values)
    assert len(splits.sides) == 2 * MAX_THRESHOLDS
    for row, counts in zip(runs.tolist(), splits.count_inside(runs).tolist(), strict=True):
        below = [sum(values[run] < float(side.value) for run in row) for side in splits.sides[::2]]
        assert counts[::2] == below
        assert counts[1::2] == [40 - count for count in below]


def compute_tail(runs: int, failing: int, size: int, inside: int) -> float:
    return float(compute_log_tails(runs, failing, np.array([size]))[0, inside])


@pytest.mark.parametrize(
    "size, inside, p",
    [
        (4, 4, 1 / 70),  # the lady tasting tea: Fisher, The Design of Experiments (1935)
        (4, 3, 17 / 70),
        (4, 0, 1.0),
        (8, 4, 1.0),
        (5, 0, 1.0),
        (3, 4, 0.0),
    ],
)
def test_fishers_p_of_four_failing_runs_among_eight(size: int, inside: int, p: float) -> None:
    assert math.exp(compute_tail(8, 4, size, inside)) == pytest.approx(p)


def test_fishers_p_is_the_tail_of_the_hypergeometric_distribution() -> None:
    ways = sum(math.comb(21, inside) * math.comb(179, 40 - inside) for inside in range(12, 22))
    assert compute_tail(200, 21, 40, 12) == pytest.approx(math.log(ways / math.comb(200, 40)), rel=1e-9)


def test_a_p_that_is_too_small_for_a_float_has_a_logarithm() -> None:
    """`math.log` accepts integers of any size."""
    exact = math.log(math.comb(5000, 3000)) - math.log(math.comb(10_000, 3000))
    assert exact < -2000
    assert compute_tail(10_000, 3000, 5000, 3000) == pytest.approx(exact, rel=1e-9)


def test_a_table_has_a_row_for_each_size() -> None:
    table = compute_log_tails(60, 12, np.array([1, 6, 59]))
    assert table.shape == (3, 13)
    assert table[1, 6] == compute_tail(60, 12, 6, 6)
