"""A simulator that others use too: left as it was, refused to a second program, recovered from a killed one."""

from __future__ import annotations

import signal
import subprocess
import sys
from typing import Any

import pytest

from drivers.coppeliasim.connection import RefusedError
from robotcore.description import load_robot
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.testing import worlds
from tests.system.coppeliasim.server import looking, opened, options


def snapshot() -> dict[str, Any]:
    """Return the paths and places of all there is, and the time step."""
    with looking() as other:
        handles = other.sim("getObjectsInTree", other.constant("handle_scene"))
        things = {other.sim("getObjectAlias", handle, 1): other.sim("getObjectPose", handle) for handle in handles}
        return {"things": things, "step": other.sim("getSimulationTimeStep"), "state": other.sim("getSimulationState")}


def require_alike(after: dict[str, Any], before: dict[str, Any]) -> None:
    assert (after["step"], after["state"]) == (before["step"], before["state"])
    assert after["things"].keys() == before["things"].keys()
    for path, place in before["things"].items():
        assert after["things"][path] == pytest.approx(place, abs=1e-6), path


def test_scene_is_left_as_it_was() -> None:
    opened(worlds.empty()).close()
    before = snapshot()
    with opened(worlds.empty(), rate_hz=25.0) as robot:
        robot.clock.sleep_until(0.2)
    require_alike(snapshot(), before)


def test_second_program_is_refused_and_the_first_goes_on() -> None:
    with opened(worlds.empty()) as first:
        with pytest.raises(BackendError, match="another program drives"):
            opened(worlds.empty())
        first.clock.sleep_until(0.2)
        assert first.clock.now() == pytest.approx(0.2)


def test_program_that_thinks_for_long_is_not_forgotten() -> None:
    with opened(worlds.empty()) as robot:
        robot.clock.sleep_until(0.1)
        wall = MonotonicClock()
        wall.sleep_until(8.0)
        robot.clock.sleep_until(0.2)


def test_killed_program_is_recovered_from() -> None:
    opened(worlds.empty()).close()
    before = snapshot()
    found = options()
    command = [sys.executable, "-m", "robotcore", "run", "avoid-obstacles", "--backend", "coppeliasim", "--realtime"]
    where = ["--host", str(found["host"]), "--port", str(found["port"]), "--option", f"answer_s={found['answer_s']}"]
    with subprocess.Popen([*command, *where, "--set", "duration_s=600"], stderr=subprocess.DEVNULL) as app:
        with looking() as other:
            wall = MonotonicClock()
            while other.sim("getSimulationTime") < 0.3:
                assert wall.now() < 60
                wall.sleep_until(wall.now() + 0.1)
        app.send_signal(signal.SIGKILL)
    opened(worlds.empty()).close()
    require_alike(snapshot(), before)


def test_pause_and_stop_of_somebody_are_reported_by_name() -> None:
    for name, said in (("pauseSimulation", "paused by somebody"), ("stopSimulation", "stopped by somebody")):
        robot = opened(worlds.empty())
        with looking() as other:
            other.sim(name)
            with pytest.raises(BackendError, match=said):
                robot.clock.sleep_until(1.0)
        robot.close()


def test_robot_that_was_kept_is_joined() -> None:
    opened(worlds.empty(), keep=True).close()
    rover = load_robot("rover")
    section = {name: {"path": f"/rover/{name}"} for name in ("left_motor", "right_motor", "eye")}
    section |= {f"{side}_encoder": {"path": f"/rover/{side}_motor"} for side in ("left", "right")}
    joining = rover.model_copy(update={"backends": {"coppeliasim": section}})
    try:
        with opened(worlds.empty(), *section, robot=joining) as robot:
            assert robot.truth
            before = robot.truth.pose()
            for motor in robot.motors.values():
                motor.set_velocity(4.0)
            robot.clock.sleep_until(2.0)
            ahead, _ = before.to_local(*robot.truth.pose()[:2])
            assert robot.camera.read().image.any()
        assert ahead == pytest.approx(2.0 * 4.0 * 0.0325, rel=0.05)
    finally:
        opened(worlds.empty()).close()


def test_errors_of_the_server_end_nothing() -> None:
    with looking() as other:
        with pytest.raises(RefusedError, match="object does not exist"):
            other.sim("getObjectPosition", 999999)
        assert other.call_as(float, "getSimulationTimeStep") > 0
