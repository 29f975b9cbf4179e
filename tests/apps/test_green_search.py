from __future__ import annotations

import pytest

from robotcore import Outcome, RunRequest, run


@pytest.mark.slow
@pytest.mark.parametrize("world", ["arena", "open", "clutter", "occluded"])
def test_finds_the_ball_in_every_shipped_world(world: str) -> None:
    result = run(RunRequest("green-search", world=world))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed", [101, 102, 103])
def test_finds_the_ball_in_worlds_drawn_from_a_seed(seed: int) -> None:
    result = run(RunRequest("green-search", world="arena", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed", [300, 302])
def test_finds_a_ball_behind_obstacles(seed: int) -> None:
    result = run(RunRequest("green-search", world="occluded", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
def test_reaches_its_milestones_in_their_order() -> None:
    times = list(run(RunRequest("green-search", world="open")).milestones.items())
    assert [name for name, _ in times] == ["search", "seen", "approach", "arrived"]
    assert [time for _, time in times] == sorted(time for _, time in times)


@pytest.mark.slow
def test_decisions_depend_on_the_seed_only() -> None:
    first, again, other = (run(RunRequest("green-search", world="open", seed=seed)) for seed in (4, 4, 5))
    assert first.trace_sha256 == again.trace_sha256 != other.trace_sha256


@pytest.mark.slow
def test_searches_until_the_timeout_if_nothing_has_the_hue() -> None:
    result = run(RunRequest("green-search", world="open", settings={"hue": "magenta"}, timeout_s=20))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.TIMEOUT, False, 0)
    assert "seen" not in result.milestones


@pytest.mark.slow
@pytest.mark.parametrize(
    "fault, seed",
    [("range spikes=0.05", 4), ("encoders slip=0.05", 18), ("encoders slip=0.05", 19), ("encoders delay=0.1", 17)],
)
def test_finds_the_ball_with_faulty_sensors_in_difficult_rooms(fault: str, seed: int) -> None:
    """With these faults and seeds, an app that trusts every sample touches an obstacle or finds no path."""
    result = run(RunRequest("green-search", world="arena", seed=seed, faults=(fault,)))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed, fault", [(20922, "left_encoder slip=1 after=7.54 lasts=0.33")])
def test_finds_the_ball_after_a_wheel_slipped_and_the_range_guard_held_the_robot(seed: int, fault: str) -> None:
    result = run(RunRequest("green-search", world="arena", seed=seed, faults=(fault,)))
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True), result.reason
