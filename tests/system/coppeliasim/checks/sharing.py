"""Checks of sharing a simulator: scenes are restored, also after a program was killed, and a second one is refused."""

from __future__ import annotations

import signal
import subprocess
import sys
from typing import Any

import pytest

from drivers.coppeliasim.address import RefusedError
from robotcore.description import load_robot
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.testing import worlds
from tests.system.coppeliasim.server import connect, open_robot, options


def take_snapshot() -> dict[str, Any]:
    """Return the paths and poses of all objects, the time step and the state."""
    with connect() as other:
        handles = other.sim("getObjectsInTree", other.constant("handle_scene"))
        poses = {other.sim("getObjectAlias", handle, 1): other.sim("getObjectPose", handle) for handle in handles}
        return {"poses": poses, "step": other.sim("getSimulationTimeStep"), "state": other.sim("getSimulationState")}


def require_equal(after: dict[str, Any], before: dict[str, Any]) -> None:
    assert (after["step"], after["state"]) == (before["step"], before["state"])
    assert after["poses"].keys() == before["poses"].keys()
    for path, place in before["poses"].items():
        assert after["poses"][path] == pytest.approx(place, abs=1e-6), path


def test_scene_is_restored() -> None:
    open_robot(worlds.empty()).close()
    before = take_snapshot()
    with open_robot(worlds.empty(), rate_hz=25.0) as robot:
        robot.clock.sleep_until(0.2)
    require_equal(take_snapshot(), before)


def test_second_program_is_refused_and_the_first_continues() -> None:
    with open_robot(worlds.empty()) as first:
        with pytest.raises(BackendError) as caught:
            open_robot(worlds.empty())
        assert caught.value.kind == "lease-held"
        first.clock.sleep_until(0.2)
        assert first.clock.now() == pytest.approx(0.2)


def test_program_that_computes_for_long_is_not_dropped() -> None:
    with open_robot(worlds.empty()) as robot:
        robot.clock.sleep_until(0.1)
        wall = MonotonicClock()
        wall.sleep_until(8.0)
        robot.clock.sleep_until(0.2)


def test_next_program_restores_the_scene_of_a_killed_one() -> None:
    open_robot(worlds.empty()).close()
    before = take_snapshot()
    found = options()
    command = [sys.executable, "-m", "robotcore", "run", "avoid-obstacles", "--backend", "coppeliasim", "--realtime"]
    where = ["--host", str(found["host"]), "--port", str(found["port"]), "--option", f"answer_s={found['answer_s']}"]
    with subprocess.Popen([*command, *where, "--set", "duration_s=600"], stderr=subprocess.DEVNULL) as app:
        with connect() as other:
            wall = MonotonicClock()
            while other.sim("getSimulationTime") < 0.3:
                assert wall.now() < 60
                wall.sleep_until(wall.now() + 0.1)
        app.send_signal(signal.SIGKILL)
    open_robot(worlds.empty()).close()
    require_equal(take_snapshot(), before)


def test_pause_and_stop_by_the_user_are_errors() -> None:
    for name, kind in (("pauseSimulation", "simulation-paused"), ("stopSimulation", "simulation-stopped")):
        robot = open_robot(worlds.empty())
        with connect() as other:
            other.sim(name)
            with pytest.raises(BackendError) as caught:
                robot.clock.sleep_until(1.0)
            assert caught.value.kind == kind
        robot.close()


def test_kept_robot_can_be_joined() -> None:
    open_robot(worlds.empty(), keep=True).close()
    rover = load_robot("rover")
    section = {name: {"path": f"/rover/{name}"} for name in ("left_motor", "right_motor", "eye")}
    section |= {f"{side}_encoder": {"path": f"/rover/{side}_motor"} for side in ("left", "right")}
    joining = rover.model_copy(update={"backends": {"coppeliasim": section}})
    try:
        with open_robot(worlds.empty(), *section, robot=joining) as robot:
            assert robot.truth
            before = robot.truth.pose()
            for motor in robot.motors.values():
                motor.set_velocity(4.0)
            robot.clock.sleep_until(2.0)
            ahead, _ = before.to_local(*robot.truth.pose()[:2])
            assert robot.camera.read().image.any()
        assert ahead == pytest.approx(2.0 * 4.0 * 0.0325, rel=0.05)
    finally:
        open_robot(worlds.empty()).close()


def test_error_of_the_server_does_not_end_the_connection() -> None:
    with connect() as other:
        with pytest.raises(RefusedError):
            other.sim("getObjectPosition", 999999)
        assert other.call_as(float, "getSimulationTimeStep") > 0
