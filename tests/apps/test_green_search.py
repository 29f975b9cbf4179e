from __future__ import annotations

import pytest

from robotcore import Outcome, RunRequest, run


@pytest.mark.parametrize("world", ["arena", "open", "clutter", "occluded"])
def test_finds_the_ball_in_every_world_as_it_is_shipped(world: str) -> None:
    result = run(RunRequest("green-search", world=world))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.parametrize("seed", [101, 102, 103])
def test_finds_the_ball_in_worlds_that_a_seed_draws(seed: int) -> None:
    result = run(RunRequest("green-search", world="arena", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.parametrize("seed", [300, 302])
def test_finds_a_ball_that_is_well_hidden(seed: int) -> None:
    result = run(RunRequest("green-search", world="occluded", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


def test_reaches_its_milestones_in_their_order() -> None:
    times = list(run(RunRequest("green-search", world="open")).milestones.items())
    assert [name for name, _ in times] == ["search", "seen", "approach", "arrived"]
    assert [time for _, time in times] == sorted(time for _, time in times)


def test_the_same_seed_twice_decides_the_same_and_another_seed_does_not() -> None:
    first, again, other = (run(RunRequest("green-search", world="open", seed=seed)) for seed in (4, 4, 5))
    assert first.trace_sha256 == again.trace_sha256 != other.trace_sha256


def test_searches_for_another_hue_without_end_where_nothing_has_it() -> None:
    result = run(RunRequest("green-search", world="open", settings={"hue": "magenta"}, timeout_s=20))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.TIMEOUT, False, 0)
    assert "seen" not in result.milestones


@pytest.mark.parametrize(
    "fault, seed",
    [("range spikes=0.05", 4), ("encoders slip=0.05", 18), ("encoders slip=0.05", 19), ("encoders delay=0.1", 17)],
)
def test_finds_the_ball_by_sensors_that_mislead_where_their_word_alone_would_lead_astray(fault: str, seed: int) -> None:
    """Without looking for contradictions the app touched something, or found no way, in each of these rooms."""
    result = run(RunRequest("green-search", world="arena", seed=seed, faults=(fault,)))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason
