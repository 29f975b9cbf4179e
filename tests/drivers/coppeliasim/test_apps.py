"""Apps on CoppeliaSim's double: the very same that run on every backend."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import ProximitySensor
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.scenes import bubblerob_scene, default_scene, relay_scene

YELLOW = (255, 255, 0)


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with Double(default_scene()) as double:
        yield double.zmq_port


def run_on(port: int, app: str, robot: str = "rover", **asked: Any) -> RunResult:
    return run(RunRequest(app, "coppeliasim", robot, options={"port": port}, **asked))


def run_in(simulator: Simulator, app: str, robot: str, **asked: Any) -> RunResult:
    with Double(simulator) as double:
        return run_on(double.zmq_port, app, robot, **asked)


def test_green_search_finds_the_ball_and_the_simulator_sees_it_there(port: int) -> None:
    result = run_on(port, "green-search", world="arena", seed=3)
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason
    assert list(result.milestones) == ["search", "seen", "approach", "arrived"]
    assert result.notes == ["nose measures by a proximity sensor"]


def test_obstacles_are_avoided(port: int) -> None:
    result = run_on(port, "avoid-obstacles", world="clutter", settings={"duration_s": 10.0})
    assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0), result.reason


def test_green_is_marked_in_a_scene_that_is_built(port: int) -> None:
    result = run_on(port, "mark-green", world="open", seed=6, settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason


def test_bubblerob_avoids_what_stands_around_and_its_scene_is_stopped_again() -> None:
    simulator = bubblerob_scene()
    nose = simulator.graph.find("/bubbleRob/sensingNose")
    assert isinstance(nose, ProximitySensor)
    nose.reach = 0.5  # as the robot's file asks for
    result = run_in(simulator, "avoid-obstacles", "bubblerob", settings={"duration_s": 12.0})
    assert (result.outcome, "avoid" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    assert simulator.state is State.STOPPED


def test_marked_picture_goes_to_the_second_vision_sensor_upright(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = relay_scene()
    shown: list[np.ndarray] = []
    monkeypatch.setattr(simulator, "show", lambda _sensor, pixels: shown.append(np.array(pixels)))
    result = run_in(simulator, "mark-green", "lookout", settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    seen_by_a_human = shown[-1][::-1]
    yellow = (abs(seen_by_a_human.astype(int) - YELLOW) < 60).all(axis=2)
    assert yellow.any()


def test_robot_that_joins_must_not_be_driven_blindly() -> None:
    simulator = bubblerob_scene()
    simulator.can_detect = False
    result = run_in(simulator, "avoid-obstacles", "bubblerob", settings={"duration_s": 1.0})
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert "nose: the CoppeliaSim at" in result.reason
    assert "every way seems free" in result.reason
