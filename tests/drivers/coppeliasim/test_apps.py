"""Run the shipped apps on the double of CoppeliaSim."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from robotcore.errors import DeviceError
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator, State
from tests.doubles.coppeliasim.scene.objects import ProximitySensor
from tests.doubles.coppeliasim.scenes import bubblerob_scene, default_scene, relay_scene
from tests.texts import CheckText

YELLOW = (255, 255, 0)


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with Double(default_scene()) as double:
        yield double.zmq_port


def run_on(port: int, app: str, robot: str = "rover", **request: Any) -> RunResult:
    return run(RunRequest(app, "coppeliasim", robot, options={"port": port}, **request))


def run_in(simulator: Simulator, app: str, robot: str, **request: Any) -> RunResult:
    with Double(simulator) as double:
        return run_on(double.zmq_port, app, robot, **request)


@pytest.mark.slow
def test_green_search_finds_the_ball_and_the_truth_verifies_it(port: int, check_text: CheckText) -> None:
    result = run_on(port, "green-search", world="arena", seed=3)
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason
    assert list(result.milestones) == ["search", "seen", "approach", "arrived"]
    check_text("\n".join(result.notes))


@pytest.mark.slow
def test_avoid_obstacles_touches_nothing(port: int) -> None:
    result = run_on(port, "avoid-obstacles", world="clutter", settings={"duration_s": 10.0})
    assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0), result.reason


def test_mark_green_runs_in_a_built_scene(port: int) -> None:
    result = run_on(port, "mark-green", world="open", seed=6, settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason


@pytest.mark.slow
def test_bubblerob_avoids_obstacles_and_its_simulation_is_stopped_again() -> None:
    simulator = bubblerob_scene()
    nose = simulator.graph.find("/bubbleRob/sensingNose")
    assert isinstance(nose, ProximitySensor)
    nose.reach = 0.5  # the range in the robot's file
    result = run_in(simulator, "avoid-obstacles", "bubblerob", settings={"duration_s": 12.0})
    assert (result.outcome, "cruise" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    assert simulator.state is State.STOPPED


def test_marked_picture_is_shown_upright_on_the_second_vision_sensor(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = relay_scene()
    shown: list[np.ndarray] = []
    monkeypatch.setattr(simulator, "show", lambda _sensor, pixels: shown.append(np.array(pixels)))
    result = run_in(simulator, "mark-green", "lookout", settings={"duration_s": 0.5})
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    upright = shown[-1][::-1]
    yellow = (abs(upright.astype(int) - YELLOW) < 60).all(axis=2)
    assert yellow.any()


def test_joining_is_refused_if_proximity_sensors_do_not_work(check_text: CheckText) -> None:
    simulator = bubblerob_scene()
    simulator.can_detect = False
    with Double(simulator) as double:
        result = run_on(double.zmq_port, "avoid-obstacles", "bubblerob", settings={"duration_s": 1.0})
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, DeviceError)
    assert (result.error.device, result.error.kind) == ("nose", "sensor-not-simulated")
    check_text(result.reason, hide=[double.zmq_port])
