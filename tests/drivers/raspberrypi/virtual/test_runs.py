"""The app green-search finds the ball in a simulator, and also with the Pi's drivers on virtual pins."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from robotcore import RunRequest, RunResult, run
from robotcore.recording.replay.verification import replay
from robotcore.sweep import LocalEngine, Sweep, run_sweep
from tests.robotcore.recording.replay.memory import record_run


@cache
def find_ball(backend: str, seed: int) -> RunResult:
    return run(RunRequest("green-search", backend, seed=seed))


def run_search(**asked: Any) -> RunResult:
    return run(RunRequest("green-search", "virtualpi", **asked))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 7])
def test_the_ball_is_found_through_gpiozero_by_the_same_milestones(seed: int) -> None:
    real, simulated = find_ball("virtualpi", seed), find_ball("kinematic", seed)
    assert real.verified
    assert list(real.milestones) == list(simulated.milestones)
    assert real.contacts == 0


@pytest.mark.slow
def test_the_same_seed_gives_the_same_digest() -> None:
    assert run_search(seed=7).trace_sha256 == find_ball("virtualpi", 7).trace_sha256


@pytest.mark.slow
@pytest.mark.usefixtures("pybullet")
def test_the_ball_that_is_found_in_bullet_is_found_there_through_gpiozero() -> None:
    assert run_search(seed=7, options={"simulator": "pybullet"}).verified


@pytest.mark.slow
def test_the_ball_is_found_if_a_third_of_the_echoes_is_lost() -> None:
    result = run_search(seed=7, options={"lost_echoes": "0.33"})
    assert result.verified
    assert result.trace_sha256 != find_ball("virtualpi", 7).trace_sha256


@pytest.mark.slow
def test_the_ball_is_found_in_a_world_with_conditions_of_its_own() -> None:
    result = run_search(seed=7, randomise=True)
    assert result.verified
    assert result.trace_sha256 != find_ball("virtualpi", 7).trace_sha256


@pytest.mark.slow
def test_a_recorded_run_replays_to_the_bit() -> None:
    replayed = replay(record_run(backend="virtualpi", seed=7))
    assert replayed.is_equal


@pytest.mark.slow
def test_a_sweep_has_the_results_of_its_runs() -> None:
    sweep = Sweep(RunRequest("green-search"), ("virtualpi",), ("arena",), (1, 2))
    digests = {record.result.seed: record.result.trace_sha256 for record in run_sweep(sweep, LocalEngine(2)).records()}
    assert digests == {seed: find_ball("virtualpi", seed).trace_sha256 for seed in (1, 2)}
