"""Apps on V-REP's double: the very same that run on every backend."""

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
from tests.doubles.coppeliasim.scene.objects import Joint
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import bubblerob_scene, described_scene, relay_scene

YELLOW = (255, 255, 0)


@contextmanager
def served(simulator: Simulator) -> Iterator[int]:
    with LegacyServer(simulator) as server:
        yield server.port


def arena(robot: str, seed: int) -> Simulator:
    described = load_robot(robot)
    return described_scene(described, draw_world(load_world("arena"), described, seed))


def run_on(simulator: Simulator, app: str, robot: str = "rover", **asked: Any) -> RunResult:
    with served(simulator) as port:
        options = {"port": port, **asked.pop("options", {})}
        return run(RunRequest(app, "vrep", robot, options=options, **asked))


@pytest.mark.parametrize("seed", [1, 7])
def test_green_search_finds_the_ball_and_the_simulator_sees_it_there(seed: int) -> None:
    simulator = arena("rover", seed)
    result = run_on(simulator, "green-search", world="arena", seed=seed)
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True), result.reason
    assert list(result.milestones) == ["search", "seen", "approach", "arrived"]
    assert "'arena'" in result.notes[-1]


def test_simulation_that_was_stopped_is_stopped_again() -> None:
    simulator = arena("rover", 1)
    result = run_on(simulator, "avoid-obstacles", settings={"duration_s": 0.5})
    assert simulator.state is State.STOPPED
    assert result.notes == []


def test_simulation_that_ran_runs_on_and_the_wheels_stand() -> None:
    simulator = arena("rover", 1)
    with LegacyServer(simulator) as server:
        with simulator.lock:
            simulator.start()
        run(RunRequest("avoid-obstacles", "vrep", settings={"duration_s": 0.5}, options={"port": server.port}))
        with simulator.lock:
            before = simulator.time
            assert simulator.changed.wait_for(lambda: simulator.time > before, 5)
        joint = simulator.graph.find("/rover/left_motor")
    assert isinstance(joint, Joint)
    assert joint.target_velocity == 0


def test_bubblerob_avoids_what_stands_around_in_the_tutorials_scene() -> None:
    result = run_on(bubblerob_scene(), "avoid-obstacles", "bubblerob", settings={"duration_s": 12.0})
    assert (result.outcome, "avoid" in result.milestones) == (Outcome.SUCCESS, True), result.reason


@pytest.mark.parametrize("robot", ["rover", "lookout"])
def test_marked_picture_goes_to_the_second_vision_sensor_upright(robot: str, monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = relay_scene()
    shown: list[np.ndarray] = []
    monkeypatch.setattr(simulator, "show", lambda _sensor, pixels: shown.append(np.array(pixels)))
    result = run_on(simulator, "mark-green", robot, settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    seen_by_a_human = shown[-1][::-1]
    rows, columns = np.nonzero((abs(seen_by_a_human.astype(int) - YELLOW) < 60).all(axis=2))
    assert seen_by_a_human.shape == (256, 256, 3)
    assert (rows.mean() > 128, columns.mean() < 128) == (True, True), "the ball is on the lower left"
