"""Failure analysis: conditions that have a significant split, and conditions that have none."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

import pytest

from robotcore.sweep.failure_analysis import FailureCount, compute_fisher_p, explain
from robotcore.sweep.record import Record
from tests.robotcore.sweep.report.samples import make_fail, make_pass
from tests.texts import CheckText

ARENA = "in arena on kinematic"


def make_record(*, fails: bool, **values: Any) -> Record:
    return (make_fail if fails else make_pass)(**values)


def run(*, fails: bool, **conditions: float | str) -> Record:
    return make_record(fails=fails, conditions=conditions)


def list_sides(records: Sequence[Record]) -> list[tuple[str, str, FailureCount, FailureCount]]:
    """Return the group, the side and the shares of each significant split."""
    return [(str(each.group), each.side, each.inside, each.outside) for each in explain(records).splits]


@pytest.mark.parametrize(
    "inside, outside, p",
    [
        (
            FailureCount(4, 4),
            FailureCount(0, 4),
            2 / 70,
        ),  # the lady tasting tea: Fisher, The Design of Experiments (1935)
        (FailureCount(1, 4), FailureCount(3, 4), 34 / 70),
        (FailureCount(2, 4), FailureCount(2, 4), 1.0),
        (FailureCount(8, 14), FailureCount(1, 10), 65_388 / 1_961_256),
        (FailureCount(300, 1800), FailureCount(0, 1800), 2 * math.comb(1800, 300) / math.comb(3600, 300)),
    ],
)
def test_fishers_p_has_the_values_of_the_literature(inside: FailureCount, outside: FailureCount, p: float) -> None:
    assert compute_fisher_p(inside, outside) == pytest.approx(p, rel=1e-3)
    assert compute_fisher_p(outside, inside) == pytest.approx(p, rel=1e-3)


@pytest.mark.parametrize(
    "values, side, inside, outside",
    [
        ([0.1] * 12 + [0.4] * 188, "light < 0.2", FailureCount(7, 12), FailureCount(3, 188)),
        ([0.4] * 12 + [0.1] * 188, "light ≥ 0.2", FailureCount(7, 12), FailureCount(3, 188)),
        (["wood"] * 12 + ["tiles", "plain"] * 94, "light = wood", FailureCount(7, 12), FailureCount(3, 188)),
        ([0.5] * 12 + ["auto"] * 188, "light = 0.5", FailureCount(7, 12), FailureCount(3, 188)),
        (["wood", "tiles"] * 6 + ["plain"] * 188, "light ≠ plain", FailureCount(7, 12), FailureCount(3, 188)),
        (["wood"] * 12 + ["plain"] * 188, "light = wood", FailureCount(7, 12), FailureCount(3, 188)),
        (["plain"] * 12 + ["wood"] * 188, "light = plain", FailureCount(7, 12), FailureCount(3, 188)),
    ],
    ids=["below", "above", "a word", "a word and a number", "all but a word", "second of two", "first of two"],
)
def test_the_side_on_which_more_runs_fail_is_reported(
    values: Sequence[float | str], side: str, inside: FailureCount, outside: FailureCount
) -> None:
    records = [run(fails=at < 7 or 12 <= at < 15, light=value) for at, value in enumerate(values)]
    assert list_sides(records) == [(ARENA, side, inside, outside)]


def test_the_p_is_corrected_for_the_number_of_tests_by_holms_method() -> None:
    records = [run(fails=at < 6, strong=at < 6, weak=at < 11) for at in range(60)]
    strong, weak = explain(records).splits
    assert strong.p == pytest.approx(2 * compute_fisher_p(FailureCount(6, 6), FailureCount(0, 54)))
    assert weak.p == pytest.approx(compute_fisher_p(FailureCount(6, 11), FailureCount(0, 49)))


def test_two_words_are_one_test() -> None:
    (split,) = explain([run(fails=at < 9, floor="wood" if at < 9 else "tiles") for at in range(29)]).splits
    assert split.p == pytest.approx(compute_fisher_p(FailureCount(9, 9), FailureCount(0, 20)))


@pytest.mark.parametrize("backends", [("kinematic",), ("kinematic", "pybullet")])
def test_at_most_one_sweep_of_twenty_has_a_significant_split_by_chance(backends: Sequence[str]) -> None:
    """A seed draws the same conditions on each backend, and here its runs have the same outcome."""
    dice = random.Random(1)
    sweeps = [
        [
            make_record(fails=fails, seed=seed, backend=backend, conditions=drawn)
            for seed in range(40)
            for fails in [dice.random() < 0.2]
            for drawn in [{f"condition_{index}": dice.random() for index in range(4)}]
            for backend in backends
        ]
        for _ in range(100)
    ]
    assert sum(bool(explain(records).splits) for records in sweeps) <= 5


def test_a_world_that_is_both_dark_and_hard_does_not_make_darkness_a_cause() -> None:
    dice = random.Random(1)
    worlds = {"cellar": (0.5, 0.1, 0.4), "garden": (0.02, 0.5, 1.0)}
    records = [
        make_record(fails=dice.random() < risk, world=world, conditions={"light": dice.uniform(dark, bright)})
        for world, (risk, dark, bright) in worlds.items()
        for _ in range(100)
    ]
    assert explain(records).splits == ()


@pytest.mark.parametrize("world, group", [("clutter", "in clutter on pybullet"), (None, "on pybullet")])
def test_a_split_is_of_one_world_and_one_backend(world: str | None, group: str) -> None:
    dark = [
        make_record(fails=at < 8, world=world, backend="pybullet", conditions={"light": at // 8}) for at in range(30)
    ]
    other = [run(fails=False, light=at // 8) for at in range(30)]
    without_conditions = [make_fail(world=world, backend="pybullet") for _ in range(9)]
    assert list_sides([*dark, *other, *without_conditions]) == [
        (group, "light < 0.5", FailureCount(8, 8), FailureCount(0, 22))
    ]


def test_a_line_has_the_side_the_shares_and_the_p(check_text: CheckText) -> None:
    records = [run(fails=at < 12, light=at) for at in range(48)]
    explanation = explain(records)
    check_text("\n".join(explanation.lines))
    assert (len(explanation.splits), explanation.reason) == (1, "")


def test_without_a_significant_split_the_best_split_is_reported(check_text: CheckText) -> None:
    records = [run(fails=at in (0, 1, 9), light=at) for at in range(12)]
    check_text("\n".join(explain(records).lines))


@pytest.mark.parametrize(
    "records",
    [
        [run(fails=True, light=at) for at in range(9)],
        [make_record(fails=at < 5, world="pit" if at < 5 else "open", conditions={"light": at}) for at in range(9)],
        [run(fails=at < 5, light=1, floor="wood") for at in range(9)],
        [run(fails=False, light=at) for at in range(9)],
        [make_fail(), make_pass()],
        [],
    ],
    ids=["all failed", "all or none", "all alike", "none failed", "no conditions", "no runs"],
)
def test_the_reason_for_no_significant_split_is_reported(records: Sequence[Record], check_text: CheckText) -> None:
    check_text(explain(records).reason)
    assert explain(records).splits == ()
