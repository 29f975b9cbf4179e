from __future__ import annotations

import math
import random
from typing import Any

import pytest

from robotcore.sweep.explain import Share, explain, fisher, unexplained
from robotcore.sweep.record import Record
from tests.robotcore.sweep.report.samples import failed, passed

HERE = "fails more in arena on kinematic where"


def ended(*, fails: bool, **told: Any) -> Record:
    return (failed if fails else passed)(**told)


def run(*, fails: bool, **conditions: float | str) -> Record:
    return ended(fails=fails, conditions=conditions)


def runs_by_light(dark_failing: int, dark: int, bright_failing: int, bright: int) -> list[Record]:
    """Return runs in the dark, brightness 0.1 to 0.3, and in the light, 0.4 to 1."""
    return [
        *(run(fails=at < dark_failing, light_brightness=0.1 + 0.2 * at / dark) for at in range(dark)),
        *(run(fails=at < bright_failing, light_brightness=1.0 - 0.6 * at / bright) for at in range(bright)),
    ]


@pytest.mark.parametrize(
    "inside, outside, chance",
    [
        (Share(4, 4), Share(0, 4), 1 / 70),  # the lady tasting tea: Fisher, The Design of Experiments (1935)
        (Share(3, 4), Share(1, 4), 17 / 70),
        (Share(1, 4), Share(3, 4), 1.0),
        (Share(0, 5), Share(0, 5), 1.0),
    ],
)
def test_fishers_test_gives_the_chance_of_so_many_or_more(inside: Share, outside: Share, chance: float) -> None:
    assert fisher(inside, outside) == pytest.approx(chance)


def test_fishers_test_is_the_sum_of_the_hypergeometric_tail() -> None:
    inside, outside = Share(12, 40), Share(9, 160)
    ways = sum(math.comb(21, failing) * math.comb(179, 40 - failing) for failing in range(12, 22))
    assert fisher(inside, outside) == pytest.approx(ways / math.comb(200, 40), rel=1e-9)


def test_fishers_test_takes_a_big_sweep() -> None:
    assert fisher(Share(3000, 5000), Share(0, 5000)) < 1e-300
    assert fisher(Share(0, 5000), Share(3000, 5000)) == 1.0


def test_the_threshold_that_parts_failing_from_passing_runs_is_told() -> None:
    records = runs_by_light(7, 12, 3, 188)
    (finding,) = explain(records)
    assert finding.condition == "light_brightness"
    assert finding.p < 1e-3
    assert str(finding).startswith(f"{HERE} light_brightness < 0.2")
    told = [run(fails=at < 7, light=0.1) for at in range(12)] + [run(fails=at < 3, light=0.4) for at in range(188)]
    assert [str(each) for each in explain(told)] == [f"{HERE} light < 0.2: 7 of 12, elsewhere 3 of 188"]


def test_the_side_above_a_threshold_is_told_too() -> None:
    records = [run(fails=noise >= 9, camera_noise=noise) for noise in range(12)] * 4
    assert [str(each) for each in explain(records)] == [f"{HERE} camera_noise ≥ 8.5: 12 of 12, elsewhere 0 of 36"]


def test_a_word_is_told_against_all_others() -> None:
    textures = ["wood"] * 20 + ["tiles"] * 20 + ["plain"] * 20
    records = [run(fails=floor == "wood" and at % 4 > 0, floor=floor) for at, floor in enumerate(textures)]
    assert [str(each) for each in explain(records)] == [f"{HERE} floor = wood: 15 of 20, elsewhere 0 of 40"]


def test_the_surest_finding_comes_first() -> None:
    records = [run(fails=at < 12, weak=at < 30, strong=at < 14) for at in range(100)]
    assert [each.condition for each in explain(records)] == ["strong", "weak"]


@pytest.mark.parametrize("seed", range(5))
def test_chance_explains_nothing(seed: int) -> None:
    dice = random.Random(seed)
    records = [
        run(fails=dice.random() < 0.2, **{f"condition_{index}": dice.random() for index in range(8)})
        for _ in range(150)
    ]
    assert explain(records) == []


def test_chance_explains_nothing_where_backends_fail_on_the_same_layouts() -> None:
    """Chance may explain one sweep of twenty; taken for independent, two backends' runs made it every second one."""
    assert sum(bool(explain(_swept_twice(random.Random(seed)))) for seed in range(60)) <= 6


def _swept_twice(dice: random.Random) -> list[Record]:
    """Return the runs of two backends; both draw the same, and fail where the layout is hard."""
    return [
        ended(fails=fails, backend=backend, conditions=drawn)
        for _ in range(100)
        for fails in [dice.random() < 0.15]
        for drawn in [{f"condition_{index}": dice.random() for index in range(8)}]
        for backend in ("kinematic", "pybullet")
    ]


def test_a_world_that_is_both_dark_and_hard_does_not_make_the_dark_a_cause() -> None:
    dice = random.Random(1)
    worlds = {"cellar": (0.5, 0.1, 0.4), "garden": (0.02, 0.5, 1.0)}
    records = [
        ended(fails=dice.random() < risk, world=world, conditions={"light": dice.uniform(dark, bright)})
        for world, (risk, dark, bright) in worlds.items()
        for _ in range(100)
    ]
    assert explain(records) == []


@pytest.mark.parametrize(
    "world, place", [("clutter", "in clutter on pybullet"), (None, "on pybullet")], ids=["in a world", "in none"]
)
def test_a_finding_is_of_one_world_and_one_backend(world: str | None, place: str) -> None:
    dark = [ended(fails=at < 8, world=world, backend="pybullet", conditions={"light": at // 8}) for at in range(30)]
    other = [run(fails=False, light=at // 8) for at in range(30)]
    assert [str(each) for each in explain(dark + other)] == [
        f"fails more {place} where light < 0.5: 8 of 8, elsewhere 0 of 22"
    ]


def test_what_would_be_a_finding_alone_is_none_among_many_conditions() -> None:
    dice = random.Random(0)
    alone = [run(fails=at < 5, light=at < 12) for at in range(40)]
    noisy = [
        run(fails=at < 5, light=at < 12, **{f"noise_{index}": dice.random() for index in range(20)}) for at in range(40)
    ]
    assert [each.condition for each in explain(alone)] == ["light"]
    assert explain(noisy) == []


def test_a_run_that_does_not_tell_a_condition_is_left_out_of_it() -> None:
    records = [run(fails=at < 8, light=at < 8) for at in range(30)] + [failed() for _ in range(9)]
    assert [str(each) for each in explain(records)] == [f"{HERE} light ≥ 0.5: 8 of 8, elsewhere 0 of 22"]


def test_what_never_changes_explains_nothing() -> None:
    assert explain([run(fails=at < 5, light=1.0, floor="wood") for at in range(20)]) == []
    assert explain([]) == []


def test_that_nothing_was_found_is_told_only_of_failing_runs_that_tell_conditions() -> None:
    told = "nothing that chance does not explain as well (3 runs, 1 failing)"
    assert unexplained([run(fails=at == 0, light=at) for at in range(3)] + [failed()]) == [told]
    assert unexplained([run(fails=False, light=1.0), failed()]) == []
