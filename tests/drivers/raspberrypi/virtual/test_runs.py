"""The app green-search finds the ball in a simulator, and also with the Pi's drivers on virtual pins."""

from __future__ import annotations

from typing import Any

import pytest

from robotcore import RunRequest, RunResult, run
from robotcore.recording.replay.verification import replay
from tests.robotcore.recording.replay.memory import record_run


def run_search(**asked: Any) -> RunResult:
    return run(RunRequest("green-search", "virtualpi", **asked))


@pytest.mark.slow
def test_the_ball_is_found_through_gpiozero_by_the_same_milestones() -> None:
    real, simulated = run_search(seed=7), run(RunRequest("green-search", "kinematic", seed=7))
    assert real.verified
    assert list(real.milestones) == list(simulated.milestones)
    assert real.contacts == 0


@pytest.mark.slow
@pytest.mark.usefixtures("pybullet")
def test_the_ball_that_is_found_in_bullet_is_found_there_through_gpiozero() -> None:
    assert run_search(seed=7, options={"simulator": "pybullet"}).verified


@pytest.mark.slow
def test_the_ball_is_found_if_a_third_of_the_echoes_is_lost() -> None:
    assert run_search(seed=7, options={"lost_echoes": "0.33"}).verified


@pytest.mark.slow
def test_a_recorded_run_replays_to_the_bit() -> None:
    replayed = replay(record_run(backend="virtualpi", seed=7))
    assert replayed.is_equal
