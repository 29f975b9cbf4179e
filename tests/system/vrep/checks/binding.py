"""The official binding's names, by their codes."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.vrep import simx
from tests.system.vrep import scenes
from tests.system.vrep.server import WAIT, as_bytes, client, handle_of, is_running

STEP_MS = 50
STARTS = 3
"""So often it is started: servers have been seen whose time does not move after the first."""


@pytest.fixture
def number() -> Iterator[int]:
    with client() as number:
        yield number


@pytest.fixture
def relay() -> Iterator[None]:
    with scenes.relay():
        yield


def now_ms(number: int) -> int:
    assert simx.simxGetPingTime(number)[0] == simx.simx_return_ok
    return simx.simxGetLastCmdTime(number)


def start_stepped(number: int) -> None:
    """Start a simulation that waits for triggers, and take a step of it."""
    for _ in range(STARTS):
        assert simx.simxSynchronous(number, True) == simx.simx_return_ok
        assert simx.simxStartSimulation(number, WAIT) == simx.simx_return_ok
        assert simx.simxSynchronousTrigger(number) == simx.simx_return_ok
        if now_ms(number) > 0:
            return
        stop(number)
    pytest.fail("time does not move")


def stop(number: int) -> None:
    assert simx.simxStopSimulation(number, WAIT) == simx.simx_return_ok
    for _ in range(100):
        if not is_running(number):
            return
    pytest.fail("it does not stop")


@pytest.mark.usefixtures("relay")
def test_handles_are_reported_by_path_and_by_name(number: int) -> None:
    assert handle_of(number, "/v0") == handle_of(number, "v0") != handle_of(number, "v1")
    assert simx.simxGetObjectHandle(number, "/nobody", WAIT)[0] == simx.simx_return_remote_error_flag
    code, place = simx.simxGetObjectPosition(number, handle_of(number, "ball"), -1, WAIT)
    assert code == simx.simx_return_ok
    assert place == pytest.approx(scenes.BALL_M, abs=1e-4)


def test_time_moves_by_a_step_a_trigger_and_not_without(number: int) -> None:
    assert not is_running(number)
    try:
        start_stepped(number)
        assert is_running(number)
        begun = now_ms(number)
        assert now_ms(number) == begun
        for steps in range(1, 11):
            assert simx.simxSynchronousTrigger(number) == simx.simx_return_ok
            assert now_ms(number) - begun == steps * STEP_MS
    finally:
        stop(number)


def test_simulation_that_does_not_wait_goes_on_by_itself(number: int) -> None:
    assert simx.simxSynchronous(number, False) == simx.simx_return_ok
    assert simx.simxStartSimulation(number, WAIT) == simx.simx_return_ok
    try:
        times = [now_ms(number) for _ in range(40)]
        assert times[-1] > times[0]
    finally:
        stop(number)


def test_trigger_of_a_stopped_simulation_is_refused(number: int) -> None:
    assert simx.simxSynchronousTrigger(number) & simx.simx_return_remote_error_flag


@pytest.mark.usefixtures("relay")
def test_picture_that_is_sent_is_read_back(number: int) -> None:
    screen, size = handle_of(number, "v1"), [scenes.SIGHT_PX] * 2
    sent = bytes(range(256)) * (3 * scenes.SIGHT_PX)
    start_stepped(number)
    try:
        assert simx.simxGetVisionSensorImage(number, screen, 0, simx.simx_opmode_buffer)[0] == 1
        assert simx.simxSetVisionSensorImage(number, screen, sent, 0, WAIT) == simx.simx_return_ok
        code, resolution, pixels = simx.simxGetVisionSensorImage(number, screen, 0, WAIT)
        assert (code, resolution, as_bytes(pixels) == sent) == (simx.simx_return_ok, size, True)
        code, resolution, grey = simx.simxGetVisionSensorImage(number, handle_of(number, "v0"), 1, WAIT)
        assert (code, resolution, len(grey)) == (simx.simx_return_ok, size, scenes.SIGHT_PX**2)
    finally:
        stop(number)
