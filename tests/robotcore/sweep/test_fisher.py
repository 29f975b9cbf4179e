from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.sweep.fisher import log_tails


def tail(runs: int, failing: int, size: int, inside: int) -> float:
    return float(log_tails(runs, failing, np.array([size]))[0, inside])


@pytest.mark.parametrize(
    "size, inside, chance",
    [
        (4, 4, 1 / 70),  # the lady tasting tea: Fisher, The Design of Experiments (1935)
        (4, 3, 17 / 70),
        (4, 0, 1.0),
        (8, 4, 1.0),
        (5, 0, 1.0),
        (3, 4, 0.0),
    ],
)
def test_it_is_the_chance_of_so_many_or_more_of_four_among_eight(size: int, inside: int, chance: float) -> None:
    assert math.exp(tail(8, 4, size, inside)) == pytest.approx(chance)


def test_it_is_the_sum_of_the_hypergeometric_tail() -> None:
    ways = sum(math.comb(21, inside) * math.comb(179, 40 - inside) for inside in range(12, 22))
    assert tail(200, 21, 40, 12) == pytest.approx(math.log(ways / math.comb(200, 40)), rel=1e-9)


def test_a_chance_too_small_for_a_float_is_still_told() -> None:
    """`math.log` takes whole numbers of any size."""
    exact = math.log(math.comb(5000, 3000)) - math.log(math.comb(10_000, 3000))
    assert exact < -2000
    assert tail(10_000, 3000, 5000, 3000) == pytest.approx(exact, rel=1e-9)


def test_a_table_has_a_row_for_each_size() -> None:
    table = log_tails(60, 12, np.array([1, 6, 59]))
    assert table.shape == (3, 13)
    assert table[1, 6] == tail(60, 12, 6, 6)
