from __future__ import annotations

import shutil

import pytest

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current, pruning
from robotcore.deploy.agent.releases.verdict import HEALTHY, UNHEALTHY, Verdict
from robotcore.deploy.agent.system import durable
from tests.robotcore.deploy.agent.released import let_run, put

NAMES = [f"2026-11-{day:02}T00-00-00Z" for day in range(1, 10)]


@pytest.fixture
def crowded(layout: Layout) -> Layout:
    """A robot with nine releases: the first two did well, the second runs, and all that came after it failed."""
    for number, name in enumerate(NAMES):
        Verdict(HEALTHY if number < 2 else UNHEALTHY).write(put(layout, name))
    let_run(layout, NAMES[1])
    return layout


def test_the_newest_stay_and_the_one_that_runs_and_the_one_to_go_back_to(crowded: Layout) -> None:
    assert pruning.prune(crowded, keep=3) == tuple(reversed(NAMES[2:7]))
    assert current.names(crowded) == list(reversed(NAMES[:2] + NAMES[7:]))


def test_what_fails_pushes_out_nothing_that_lives(crowded: Layout) -> None:
    for name in NAMES[:6]:
        Verdict(HEALTHY).write(crowded.releases / name)
    let_run(crowded, NAMES[5])
    assert pruning.prune(crowded) == (NAMES[6], NAMES[0])


def test_what_a_trial_is_about_stays(crowded: Layout) -> None:
    durable.write(crowded.trial, f'{{"release": "{NAMES[3]}", "previous": "{NAMES[2]}"}}')
    pruning.prune(crowded, keep=1)
    assert current.names(crowded) == [NAMES[8], NAMES[3], NAMES[2], NAMES[1], NAMES[0]]


def test_environments_go_with_the_last_release_that_needs_them(crowded: Layout) -> None:
    pruning.prune(crowded, keep=1)
    assert {path.name for path in crowded.environments.iterdir()} == {
        f"digest-{name}" for name in (NAMES[8], NAMES[1], NAMES[0])
    }


def test_nothing_is_pruned_of_what_is_few(crowded: Layout) -> None:
    for name in NAMES[4:]:
        Verdict(HEALTHY).write(crowded.releases / name)
    for name in NAMES[:2]:
        shutil.rmtree(crowded.releases / name)
    let_run(crowded, NAMES[8])
    before = current.names(crowded)
    assert pruning.prune(crowded) == ()
    assert current.names(crowded) == before
