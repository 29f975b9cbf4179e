"""Checks of the functions of `drivers.vrep.simx` and their return codes."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.vrep import simx
from tests.system.vrep import scenes
from tests.system.vrep.server import WAIT, find_handle, is_running, start_client, to_bytes

STEP_MS = 50
STARTS = 3
"""The number of attempts to start the simulation. On some servers, the time advances only after the second start."""


@pytest.fixture
def number() -> Iterator[int]:
    with start_client() as number:
        yield number


@pytest.fixture
def relay() -> Iterator[None]:
    with scenes.relay():
        yield


def read_time_ms(number: int) -> int:
    assert simx.simxGetPingTime(number)[0] == simx.simx_return_ok
    return simx.simxGetLastCmdTime(number)


def start_stepped(number: int) -> None:
    """Start a simulation that waits for triggers, and simulate one step."""
    for _ in range(STARTS):
        assert simx.simxSynchronous(number, True) == simx.simx_return_ok
        assert simx.simxStartSimulation(number, WAIT) == simx.simx_return_ok
        assert simx.simxSynchronousTrigger(number) == simx.simx_return_ok
        if read_time_ms(number) > 0:
            return
        stop(number)
    pytest.fail("the time does not advance")


def stop(number: int) -> None:
    assert simx.simxStopSimulation(number, WAIT) == simx.simx_return_ok
    for _ in range(100):
        if not is_running(number):
            return
    pytest.fail("the simulation does not stop")


@pytest.mark.usefixtures("relay")
def test_handles_are_found_by_path_and_by_name(number: int) -> None:
    assert find_handle(number, "/v0") == find_handle(number, "v0") != find_handle(number, "v1")
    assert simx.simxGetObjectHandle(number, "/unknown", WAIT)[0] == simx.simx_return_remote_error_flag
    code, place = simx.simxGetObjectPosition(number, find_handle(number, "ball"), -1, WAIT)
    assert code == simx.simx_return_ok
    assert place == pytest.approx(scenes.BALL_M, abs=1e-4)


def test_each_trigger_advances_one_time_step(number: int) -> None:
    assert not is_running(number)
    try:
        start_stepped(number)
        assert is_running(number)
        start_ms = read_time_ms(number)
        assert read_time_ms(number) == start_ms
        for steps in range(1, 11):
            assert simx.simxSynchronousTrigger(number) == simx.simx_return_ok
            assert read_time_ms(number) - start_ms == steps * STEP_MS
    finally:
        stop(number)


def test_simulation_without_triggers_runs_by_itself(number: int) -> None:
    assert simx.simxSynchronous(number, False) == simx.simx_return_ok
    assert simx.simxStartSimulation(number, WAIT) == simx.simx_return_ok
    try:
        times = [read_time_ms(number) for _ in range(40)]
        assert times[-1] > times[0]
    finally:
        stop(number)


def test_trigger_of_a_stopped_simulation_is_refused(number: int) -> None:
    assert simx.simxSynchronousTrigger(number) & simx.simx_return_remote_error_flag


@pytest.mark.usefixtures("relay")
def test_shown_picture_is_read_back(number: int) -> None:
    screen, size = find_handle(number, "v1"), [scenes.SIGHT_PX] * 2
    sent = bytes(range(256)) * (3 * scenes.SIGHT_PX)
    start_stepped(number)
    try:
        assert simx.simxGetVisionSensorImage(number, screen, 0, simx.simx_opmode_buffer)[0] == 1
        assert simx.simxSetVisionSensorImage(number, screen, sent, 0, WAIT) == simx.simx_return_ok
        code, resolution, pixels = simx.simxGetVisionSensorImage(number, screen, 0, WAIT)
        assert (code, resolution, to_bytes(pixels) == sent) == (simx.simx_return_ok, size, True)
        code, resolution, grey = simx.simxGetVisionSensorImage(number, find_handle(number, "v0"), 1, WAIT)
        assert (code, resolution, len(grey)) == (simx.simx_return_ok, size, scenes.SIGHT_PX**2)
    finally:
        stop(number)
