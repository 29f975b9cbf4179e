"""Compare the double with a real server: send each recorded message, and compare each reply."""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from drivers.vrep import simx
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.legacy.client import Client
from tests.doubles.coppeliasim.legacy.codec import Code, Command, Header, encode_packets, pack, read_message, unpack
from tests.doubles.coppeliasim.legacy.comparison import (
    JOINT_RAD,
    LAST_STEPS_MS,
    ORIENTATION_RAD,
    PIXELS_MEAN,
    POSITION_M,
    TIME_MS,
    Message,
    find_differences,
)
from tests.doubles.coppeliasim.legacy.recorded import FOLDER, Reply, first_scene, later_scene, load_session
from tests.doubles.coppeliasim.legacy.server import Service, TemporaryService
from tests.doubles.coppeliasim.scene.simulator import Simulator

RUNNING_FOR_S = 4.95
"""The simulated time before the first message to the temporary service, in seconds.

After 60 messages, at 7.95 s, the recorded client began to step.
"""

STOP = (2).to_bytes(4, "little")


class MessageSteppedService(Service):
    """A service that simulates one time step with each message if no client steps, as in the recordings."""

    def _turn(self, client: Client) -> None:
        super()._turn(client)
        if self._simulator.state.is_advancing and not self._simulator.stepping.is_in_use:
            self._simulator.advance()


class TemporaryMessageSteppedService(MessageSteppedService, TemporaryService):
    pass


def running(simulator: Simulator) -> Simulator:
    """Return a simulator after some simulated time."""
    with simulator.lock:
        simulator.start()
        simulator.time = RUNNING_FOR_S
    return simulator


SESSIONS: dict[str, tuple[Callable[[], Simulator], type[Service]]] = {
    "legacy-wire.jsonl": (first_scene, MessageSteppedService),
    "legacy-wire-2.jsonl": (partial(later_scene, 180), MessageSteppedService),
    "legacy-wire-19999.jsonl": (lambda: running(later_scene(215)), TemporaryMessageSteppedService),
}


def send_all(service: Service, messages: list[bytes]) -> dict[int, Message]:
    """Return the replies of a service by the number of the message."""
    replies: dict[int, Message] = {}
    with socket.create_connection(("127.0.0.1", service.port)) as line, line.makefile("rb") as coming:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with suppress(OSError, struct.error):
            for message in messages:
                line.sendall(encode_packets(message))
                header, commands = unpack(read_message(coming.read))
                replies[header.message] = (header, commands)
    return replies


def is_stop(reply: Reply) -> bool:
    return any((each.code, each.identity) == (Code.START_PAUSE_STOP_SIMULATION, STOP) for each in reply.commands)


@pytest.mark.parametrize("name", SESSIONS)
def test_each_reply_equals_the_real_servers(name: str) -> None:
    scene, service_of = SESSIONS[name]
    recorded, service = load_session(name), service_of(scene())
    try:
        replies = send_all(service, recorded.messages)
    finally:
        service.close()
    time_ms, found = TIME_MS, list[str]()
    for reply in recorded.replies:
        real = (reply.header, reply.commands)
        found += [f"{reply.answers}: {each}" for each in find_differences(real, replies[reply.answers], time_ms)]
        time_ms = LAST_STEPS_MS if is_stop(reply) else time_ms
    assert found == []


def test_each_session_has_replies() -> None:
    counts = {name: len(load_session(name).replies) for name in SESSIONS}
    assert counts == {"legacy-wire.jsonl": 56, "legacy-wire-2.jsonl": 88, "legacy-wire-19999.jsonl": 93}


@pytest.mark.parametrize("name", SESSIONS)
def test_recorded_messages_are_encoded_again(name: str) -> None:
    for message in load_session(name).messages:
        header, commands = unpack(message)
        for command in commands:
            assert unpack(pack(header, [command])) == (header, [command])


def test_difference_is_found() -> None:
    header, command = Header(3, 0, state=1), Command(Code.GET_JOINT_POSITION, 0, b"abcd", bytes(4))
    assert find_differences((header, [command]), (header, [command])) == []
    for other in (replace(command, status=1), replace(command, data=b"\0\0\x80?"), replace(command, sim_ms=50)):
        assert len(find_differences((header, [command]), (header, [other]))) == 1
    assert find_differences((header, [command]), (replace(header, state=0), [command])) == [
        "header: state 0, recorded 1"
    ]
    assert "commands" in find_differences((header, [command]), (header, []))[0]


CYCLE_MS = 1
"""The period of the client's messages; in the recording it was 5 ms."""
PATIENCE_MS = 5000

TOLERANCES = {
    "simxGetJointPosition": JOINT_RAD,
    "simxGetObjectPosition": POSITION_M,
    "simxGetObjectOrientation": ORIENTATION_RAD,
}
Call = dict[str, Any]


@pytest.fixture(autouse=True)
def _finish_clients() -> Iterator[None]:
    yield
    simx.simxFinish(-1)


@pytest.mark.parametrize("name", SESSIONS)
def test_each_call_returns_the_official_bindings_result(name: str) -> None:
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
            result = execute_call(client, call)
            if call["call"] == "simxGetLastCmdTime" and "19999" in name:
                begun_ms = begun_ms if begun_ms is not None else result - call["result"]
                result -= begun_ms
            if before["call"] == "simxStopSimulation":
                call["result"], result = get_return_code(call["result"]), get_return_code(result)
            if not is_expected(call, result):
                differing.append(f"{call['call']}{call['args']}: {result}, recorded {call['result']}"[:200])
    finally:
        simx.simxFinish(client)
        service.close()
    assert differing == []


def execute_call(client: int, call: Call) -> Any:
    """Execute a recorded call, and return its result.

    A call about a connection is repeated until the connection has ended.
    """
    function = getattr(simx, call["call"])
    clock, result = MonotonicClock(), function(client, *call["args"])
    while call["call"] == "simxGetConnectionId" and result != call["result"] and clock.now() < PATIENCE_MS / 1000:
        result = function(client, *call["args"])
    return result


def get_return_code(result: Any) -> Any:
    """Return the return code, which is the comparable part of a result while the simulation stops."""
    return result[0] if isinstance(result, (list, tuple)) else result


def is_expected(call: Call, result: Any) -> bool:
    """Return whether a result equals the recorded one within the tolerance. Signals have no recorded results."""
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
        return bool(result[0] == recorded[0]) and _are_pictures_similar(result[1], recorded[1])
    if function == "simxGetLastErrors":
        return _remove_repetitions(result[0]) == _remove_repetitions(recorded[0])
    if tolerance := TOLERANCES.get(function):
        return bool(np.allclose(result[0], recorded[0], rtol=0, atol=tolerance))
    return result == recorded


def _remove_repetitions(errors: list[str]) -> list[str]:
    """Return the distinct error texts in order. A failed stream adds one text with each message."""
    return list(dict.fromkeys(errors))


def _are_pictures_similar(result: list[int], recorded: list[int]) -> bool:
    one, other = (np.array(pixels, np.int8).view(np.uint8).astype(int) for pixels in (result, recorded))
    return one.shape == other.shape and (not one.size or bool(np.abs(one - other).mean() <= PIXELS_MEAN))
