"""What the official binding got from a real server, call by call, the pure-Python one gets from the double."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from drivers.vrep import simx
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.legacy.comparing import JOINT_RAD, ORIENTATION_RAD, PIXELS_MEAN, POSITION_M
from tests.doubles.coppeliasim.legacy.recorded import FOLDER
from tests.doubles.coppeliasim.legacy.test_recorded import SESSIONS

CYCLE_MS = 1
"""How often the client says something; the recorded one did every 5 ms."""
PATIENCE_MS = 5000

TOLERANCES = {
    "simxGetJointPosition": JOINT_RAD,
    "simxGetObjectPosition": POSITION_M,
    "simxGetObjectOrientation": ORIENTATION_RAD,
}
Call = dict[str, Any]


@pytest.fixture(autouse=True)
def _every_client_is_finished() -> Iterator[None]:
    yield
    simx.simxFinish(-1)


@pytest.mark.parametrize("name", SESSIONS)
def test_every_call_returns_what_the_official_binding_returned(name: str) -> None:
    calls = json.loads((FOLDER / name.replace("wire", "calls").replace("jsonl", "json")).read_text())
    scene, service_of = SESSIONS[name]
    service = service_of(scene())
    client, differing, begun_ms = -1, list[str](), None
    try:
        for before, call in pairwise([{"call": None}, *calls]):
            if call["call"] == "simxStart":
                client = simx.simxStart("127.0.0.1", service.port, True, True, PATIENCE_MS, CYCLE_MS)
                assert client == call["result"]
                continue
            result = called(client, call)
            if call["call"] == "simxGetLastCmdTime" and "19999" in name:
                begun_ms = begun_ms if begun_ms is not None else result - call["result"]
                result -= begun_ms
            if before["call"] == "simxStopSimulation":
                call["result"], result = code_of(call["result"]), code_of(result)
            if not agrees(call, result):
                differing.append(f"{call['call']}{call['args']}: {result}, recorded {call['result']}"[:200])
    finally:
        simx.simxFinish(client)
        service.close()
    assert differing == []


def called(client: int, call: Call) -> Any:
    """Return what the call returns now; one about a connection that has to end is made until it has."""
    function = getattr(simx, call["call"])
    clock, result = MonotonicClock(), function(client, *call["args"])
    while call["call"] == "simxGetConnectionId" and result != call["result"] and clock.now() < PATIENCE_MS / 1000:
        result = function(client, *call["args"])
    return result


def code_of(result: Any) -> Any:
    """Return all that can be compared while a simulation stops: it may have stopped, or not yet."""
    return result[0] if isinstance(result, (list, tuple)) else result


def agrees(call: Call, result: Any) -> bool:
    """Return whether a result is the recorded one, within tolerance; the recorder noted no result for signals."""
    recorded = call["result"]
    if recorded is None:
        return True
    if not isinstance(recorded, list):
        return type(result) is type(recorded) and result == recorded
    same = [type(each) for each in result] == [type(each) for each in recorded] and result[0] == recorded[0]
    return same and _values_agree(call["call"], list(result[1:]), recorded[1:])


def _values_agree(function: str, result: list[Any], recorded: list[Any]) -> bool:
    if function == "simxGetPingTime":
        return True
    if function == "simxReadProximitySensor":
        return bool(result[0] == recorded[0] and [len(each) for each in (result[1], result[3])] == [3, 3])
    if function == "simxGetVisionSensorImage":
        return bool(result[0] == recorded[0]) and _pictures_agree(result[1], recorded[1])
    if function == "simxGetLastErrors":
        return _each_once(result[0]) == _each_once(recorded[0])
    if tolerance := TOLERANCES.get(function):
        return bool(np.allclose(result[0], recorded[0], rtol=0, atol=tolerance))
    return result == recorded


def _each_once(errors: list[str]) -> list[str]:
    """Return the texts in order: a stream that fails adds one with each message, however many there are."""
    return list(dict.fromkeys(errors))


def _pictures_agree(result: list[int], recorded: list[int]) -> bool:
    """Compare pixels, signed bytes as the binding gives them, on average."""
    one, other = (np.array(pixels, np.int8).view(np.uint8).astype(int) for pixels in (result, recorded))
    return one.shape == other.shape and (not one.size or bool(np.abs(one - other).mean() <= PIXELS_MEAN))
