"""Run the shipped apps."""

from __future__ import annotations

from typing import Any

import pytest

from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.system.coppeliasim.server import options


def run_on(app: str, **request: Any) -> RunResult:
    return run(RunRequest(app, "coppeliasim", options=options(), **request))


@pytest.mark.parametrize("seed", [1, 3])
def test_green_search_finds_the_ball(seed: int) -> None:
    result = run_on("green-search", world="arena", seed=seed)
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


def test_avoid_obstacles_touches_nothing() -> None:
    result = run_on("avoid-obstacles", world="clutter", settings={"duration_s": 20.0})
    assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0), result.reason


def test_mark_green_sees_the_ball() -> None:
    result = run_on("mark-green", world="open", seed=6, settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
