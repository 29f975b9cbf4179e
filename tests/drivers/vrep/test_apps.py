"""Apps on V-REP's double: the very same that run on every backend."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from robotcore.description import draw_world, load_robot, load_world
from robotcore.running.outcome import Outcome, RunResult
from robotcore.running.plan import RunRequest
from robotcore.running.session import run
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Primitive, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State
from tests.drivers.vrep.rovers import AHEAD, scene_of

YELLOW = (255, 255, 0)


@contextmanager
def served(simulator: Simulator) -> Iterator[int]:
    with LegacyServer(simulator) as server:
        yield server.port


def arena(robot: str, seed: int) -> Simulator:
    described = load_robot(robot)
    return scene_of(described, draw_world(load_world("arena"), described, seed))


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


def test_simulation_that_was_stopped_is_stopped_again() -> None:
    simulator = arena("rover", 1)
    run_on(simulator, "avoid-obstacles", settings={"duration_s": 0.5})
    assert simulator.state is State.STOPPED


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
    assert joint is not None
    assert joint.target_velocity == 0  # type: ignore[attr-defined]


def test_bubblerob_avoids_what_stands_around() -> None:
    simulator = arena("bubblerob", 3)
    for name in ("left", "right"):
        thing = simulator.graph.find(f"/bubblerob/{name}_motor")
        assert thing
        thing.alias = f"{name}Motor"
    for old, new in (("/bubblerob/nose", "sensingNose"), ("/bubblerob", "bubbleRob")):
        thing = simulator.graph.find(old)
        assert thing
        thing.alias = new
    result = run_on(simulator, "avoid-obstacles", "bubblerob", settings={"duration_s": 6.0})
    assert (result.outcome, "avoid" in result.milestones) == (Outcome.SUCCESS, True), result.reason


def relay(size: tuple[int, int] = (64, 48)) -> Simulator:
    """The scene of the tutorial: a camera v0 that sees something green on its upper left, and a screen v1."""
    graph = Graph()
    ball = Shape("ball", primitive=Primitive.SPHEROID, size=(0.4, 0.4, 0.4), colour=(0.0, 1.0, 0.0))
    graph.put(graph.add(ball), Transform((2.0, 0.5, 1.4)))
    ahead: Quaternion = AHEAD
    graph.put(graph.add(VisionSensor("v0", width=128, height=128)), Transform((0.0, 0.0, 1.0), ahead))
    graph.add(VisionSensor("v1", width=size[0], height=size[1], takes_external_pictures=True))
    return Simulator(graph)


@pytest.mark.parametrize("robot", ["rover", "lookout"])
def test_marked_picture_goes_to_the_second_vision_sensor_upright(robot: str, monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = relay()
    shown: list[np.ndarray] = []
    monkeypatch.setattr(simulator, "show", lambda _sensor, pixels: shown.append(np.array(pixels)))
    result = run_on(simulator, "mark-green", robot, settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    seen_by_a_human = shown[-1][::-1]
    rows, columns = np.nonzero((abs(seen_by_a_human.astype(int) - YELLOW) < 60).all(axis=2))
    assert seen_by_a_human.shape == (48, 64, 3)
    assert (rows.mean() < 24, columns.mean() < 32) == (True, True)
