"""The apps, with motors, encoders and nose through the firmware."""

from __future__ import annotations

import pytest

from robotcore.running.outcome import Outcome
from robotcore.running.plan import RunRequest
from robotcore.running.session import run


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_green_search_finds_the_ball(seed: int) -> None:
    result = run(RunRequest("green-search", "simavr", world="arena", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


def test_obstacles_are_avoided() -> None:
    result = run(RunRequest("avoid-obstacles", "simavr", world="clutter", settings={"duration_s": 10.0}))
    assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0), result.reason
