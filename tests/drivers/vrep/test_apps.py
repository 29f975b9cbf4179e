"""Run the shipped apps on the double of V-REP."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from robotcore.description import draw_world, load_robot, load_world
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator, State
from tests.doubles.coppeliasim.scenes import bubblerob_scene, described_scene, relay_scene

YELLOW = (255, 255, 0)


@contextmanager
def serve(simulator: Simulator) -> Iterator[int]:
    with LegacyServer(simulator) as server:
        yield server.port


def create_arena(robot: str, seed: int) -> Simulator:
    description = load_robot(robot)
    return described_scene(description, draw_world(load_world("arena"), description, seed))


def run_on(simulator: Simulator, app: str, robot: str = "rover", **request: Any) -> RunResult:
    with serve(simulator) as port:
        options = {"port": port, **request.pop("options", {})}
        return run(RunRequest(app, "vrep", robot, options=options, **request))


@pytest.mark.slow
def test_green_search_finds_the_ball_and_the_truth_verifies_it() -> None:
    simulator = create_arena("rover", seed=1)
    result = run_on(simulator, "green-search", world="arena", seed=1)
    assert simulator.state is State.STOPPED
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True), result.reason
    assert list(result.milestones) == ["search", "seen", "approach", "arrived"]
    assert "'arena'" in result.notes[-1]


@pytest.mark.slow
def test_bubblerob_avoids_obstacles_in_the_tutorials_scene() -> None:
    result = run_on(bubblerob_scene(), "avoid-obstacles", "bubblerob", settings={"duration_s": 12.0})
    assert (result.outcome, "cruise" in result.milestones) == (Outcome.SUCCESS, True), result.reason


@pytest.mark.parametrize("robot", ["rover", "lookout"])
def test_marked_picture_is_shown_upright_on_the_second_vision_sensor(
    robot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulator = relay_scene()
    shown: list[np.ndarray] = []
    monkeypatch.setattr(simulator, "show", lambda _sensor, pixels: shown.append(np.array(pixels)))
    result = run_on(simulator, "mark-green", robot, settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    upright = shown[-1][::-1]
    rows, columns = np.nonzero((abs(upright.astype(int) - YELLOW) < 60).all(axis=2))
    assert upright.shape == (256, 256, 3)
    assert (rows.mean() > 128, columns.mean() < 128) == (True, True), "the ball is on the lower left"
