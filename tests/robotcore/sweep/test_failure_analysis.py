"""Failure analysis: which conditions are found, and which are not."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import pytest

from robotcore.sweep import permutation_test as shuffling
from robotcore.sweep.failure_analysis import Finding, explain
from robotcore.sweep.record import Record
from tests.robotcore.sweep.report.samples import failed, passed

HERE = "fails more in arena on kinematic where"


def ended(*, fails: bool, **values: Any) -> Record:
    return (failed if fails else passed)(**values)


def run(*, fails: bool, **conditions: float | str) -> Record:
    return ended(fails=fails, conditions=conditions)


def findings(records: Sequence[Record]) -> list[Finding]:
    return list(explain(records).findings)


def runs_by_light(dark_failing: int, dark: int, bright_failing: int, bright: int) -> list[Record]:
    """Return runs in the dark, brightness 0.1 to 0.3, and in the light, 0.4 to 1."""
    return [
        *(run(fails=at < dark_failing, light_brightness=0.1 + 0.2 * at / dark) for at in range(dark)),
        *(run(fails=at < bright_failing, light_brightness=1.0 - 0.6 * at / bright) for at in range(bright)),
    ]


def test_the_threshold_that_parts_failing_from_passing_runs_is_reported() -> None:
    records = runs_by_light(7, 12, 3, 188)
    (finding,) = findings(records)
    assert finding.condition == "light_brightness"
    assert finding.p == 0.001
    assert str(finding).startswith(f"{HERE} light_brightness < 0.2")
    records = [run(fails=at < 7, light=0.1) for at in range(12)] + [run(fails=at < 3, light=0.4) for at in range(188)]
    assert [str(each) for each in findings(records)] == [f"{HERE} light < 0.2: 7 of 12, elsewhere 3 of 188"]


def test_the_side_above_a_threshold_is_reported_too() -> None:
    records = [run(fails=noise >= 9, camera_noise=noise) for noise in range(12)] * 4
    assert [str(each) for each in findings(records)] == [f"{HERE} camera_noise ≥ 8.5: 12 of 12, elsewhere 0 of 36"]


def test_a_word_is_reported_against_all_others() -> None:
    textures = ["wood"] * 20 + ["tiles"] * 20 + ["plain"] * 20
    records = [run(fails=floor == "wood" and at % 4 > 0, floor=floor) for at, floor in enumerate(textures)]
    assert [str(each) for each in findings(records)] == [f"{HERE} floor = wood: 15 of 20, elsewhere 0 of 40"]


def test_the_surest_finding_comes_first() -> None:
    records = [run(fails=at < 12, weak=at < 30, strong=at < 14) for at in range(100)]
    assert [each.condition for each in findings(records)] == ["strong", "weak"]


def test_chance_alone_is_taken_for_a_cause_in_one_sweep_of_twenty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 300 sweeps 15 on average, and with a chance of 98 % no more than 23."""
    monkeypatch.setattr(shuffling, "SHUFFLES", 199)
    assert 4 <= sum(bool(findings(_chance(random.Random(seed)))) for seed in range(300)) <= 23


def test_backends_that_fail_on_the_same_layouts_make_chance_no_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their runs, taken for independent, made it a cause in every second sweep."""
    monkeypatch.setattr(shuffling, "SHUFFLES", 199)
    both = ("kinematic", "pybullet")
    assert sum(bool(findings(_chance(random.Random(seed), both))) for seed in range(150)) <= 14


def _chance(dice: random.Random, backends: Sequence[str] = ("kinematic",)) -> list[Record]:
    """Return runs of a robot that fails at times, whatever is drawn; every backend draws the same and fails there."""
    return [
        ended(fails=fails, seed=seed, backend=backend, conditions=drawn)
        for seed in range(40)
        for fails in [dice.random() < 0.2]
        for drawn in [{f"condition_{index}": dice.random() for index in range(4)}]
        for backend in backends
    ]


def test_what_is_plainly_there_is_found_among_many_conditions() -> None:
    """Of 60 runs 12 fail, 6 of them all that are dark: Fisher's p is 2e-5, and 3000 splits are tried."""
    dice = random.Random(3)
    dark = [0.1 + 0.025 * at for at in range(6)]
    bright = [0.3 + 0.01 * at for at in range(54)]
    records = [
        run(fails=light < 0.27 or at % 9 == 8, light=light, **{f"other_{index}": dice.random() for index in range(27)})
        for at, light in enumerate([*dark, *bright], start=-6)
    ]
    (finding,) = findings(records)
    assert (finding.where, finding.shares) == ("light < 0.3", "6 of 6, elsewhere 6 of 54")
    assert finding.p == pytest.approx(0.01, abs=0.01)


def test_the_order_in_which_runs_end_changes_nothing() -> None:
    dice = random.Random(1)
    records = [
        ended(fails=dice.random() < 0.3, seed=seed, backend=backend, conditions={"light": dice.random()})
        for seed in range(40)
        for backend in ("kinematic", "pybullet")
    ]
    lines = explain(records).lines
    dice.shuffle(records)
    assert explain(records).lines == lines


def test_a_world_that_is_both_dark_and_hard_does_not_make_the_dark_a_cause() -> None:
    dice = random.Random(1)
    worlds = {"cellar": (0.5, 0.1, 0.4), "garden": (0.02, 0.5, 1.0)}
    records = [
        ended(fails=dice.random() < risk, world=world, conditions={"light": dice.uniform(dark, bright)})
        for world, (risk, dark, bright) in worlds.items()
        for _ in range(100)
    ]
    assert findings(records) == []


@pytest.mark.parametrize(
    "world, place", [("clutter", "in clutter on pybullet"), (None, "on pybullet")], ids=["in a world", "in none"]
)
def test_a_finding_is_of_one_world_and_one_backend(world: str | None, place: str) -> None:
    dark = [ended(fails=at < 8, world=world, backend="pybullet", conditions={"light": at // 8}) for at in range(30)]
    other = [run(fails=False, light=at // 8) for at in range(30)]
    assert [str(each) for each in findings(dark + other)] == [
        f"fails more {place} where light < 0.5: 8 of 8, elsewhere 0 of 22"
    ]


def test_what_would_be_a_finding_alone_is_none_among_many_conditions() -> None:
    dice = random.Random(0)
    alone = [run(fails=at < 5, light=at < 12) for at in range(40)]
    noisy = [
        run(fails=at < 5, light=at < 12, **{f"noise_{index}": dice.random() for index in range(20)}) for at in range(40)
    ]
    assert [each.condition for each in findings(alone)] == ["light"]
    assert findings(noisy) == []


def test_a_run_that_does_not_tell_a_condition_is_left_out_of_it() -> None:
    records = [run(fails=at < 8, light=at < 8) for at in range(30)] + [failed() for _ in range(9)]
    assert [str(each) for each in findings(records)] == [f"{HERE} light ≥ 0.5: 8 of 8, elsewhere 0 of 22"]


def test_what_never_changes_explains_nothing() -> None:
    assert findings([run(fails=at < 5, light=1.0, floor="wood") for at in range(20)]) == []
    assert findings([]) == []


def test_a_chance_is_reported_with_the_finding() -> None:
    records = [run(fails=at < 12, light=at) for at in range(48)]
    assert explain(records).lines == [f"{HERE} light < 12: 12 of 12, elsewhere 0 of 36 (p = 0.001)"]
    assert explain(records).silence == ""


def test_where_nothing_is_found_no_cause_is_ruled_out_and_the_nearest_is_reported() -> None:
    records = [run(fails=at in (0, 1, 9), light=at) for at in range(12)]
    (line,) = explain(records).lines
    text = (
        "no condition can be told from chance (12 runs, 3 failing); nearest: light < 2 in arena on kinematic, 2 of 2, "
    )
    assert line.startswith(f"{text}elsewhere 1 of 10 (p = 0.")


@pytest.mark.parametrize(
    "records, reason",
    [
        (
            [run(fails=True, light=at) for at in range(9)],
            "every run failed: nothing to compare with (9 runs, 9 failing)",
        ),
        (
            [ended(fails=at < 5, world="pit" if at < 5 else "open", conditions={"light": at}) for at in range(9)],
            "in each world on each backend every run or none failed: nothing to compare with (9 runs, 5 failing)",
        ),
        ([run(fails=at < 5, light=1) for at in range(9)], "no condition differs from run to run (9 runs, 5 failing)"),
        (
            [run(fails=at < 1, light=at) for at in range(19)],
            "too few runs to tell any condition from chance (19 runs, 1 failing)",
        ),
        ([run(fails=False, light=at) for at in range(9)], ""),
        ([failed(), passed()], ""),
        ([], ""),
    ],
    ids=["all failed", "all or none", "all alike", "too few", "none failed", "no conditions", "no runs"],
)
def test_why_nothing_can_be_found_is_reported(records: Sequence[Record], reason: str) -> None:
    assert explain(records).silence == reason
    assert explain(records).findings == ()


def test_a_big_sweep_in_which_nothing_matters_says_so() -> None:
    """So many runs fail in more ways than a float can hold."""
    dice = random.Random(1)
    records = [run(fails=at < 300, light=dice.random()) for at in range(3600)]
    assert explain(records).silence.startswith("no condition can be told from chance (3600 runs, 300 failing); nearest")
