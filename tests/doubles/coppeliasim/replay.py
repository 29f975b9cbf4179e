"""Replay recorded sessions of a real server on a double, and compare the results.

A ZeroMQ session has requests and replies. The messages ``_*wait*_`` and ``_*executed*_`` are dropped, because their
number depends on timing. A legacy session has calls of the official binding and their results; `drivers.vrep.simx`
makes the same calls.
"""

from __future__ import annotations

import base64
import json
import math
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cbor
import numpy as np
import zmq

from drivers.vrep import simx
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.legacy.client import Client
from tests.doubles.coppeliasim.legacy.server import Service, TemporaryService
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scenes import default_scene, rover_scene
from tests.doubles.coppeliasim.scenes.parts import coloured_scene, walled_scene
from tests.doubles.coppeliasim.zmq.functions import load_table

RECORDED = Path(__file__).parent / "recorded"
PATIENCE_MS = 5000
PIXEL_LEVELS = 12
"""The tolerance of the mean difference between two pictures, in grey levels. The renderers differ."""

TOLERANCES = {
    "sim.getJointPosition": 0.12,
    "sim.getObjectPosition": 0.015,
    "sim.getVisionSensorDepth": 0.03,
    "simxGetJointPosition": 0.01,
    "simxGetObjectPosition": 0.006,
    "simxGetObjectOrientation": 0.005,
}
"""The tolerance of numbers by function, in metres and radians. The real robot slips, and sinks into the floor."""


def find_differences(recorded: Any, result: Any, tolerance: float = 0.0) -> Iterator[str]:
    """Yield the differences between a recorded value and a result.

    Types, lengths, keys, texts and integers must be equal. Bytes are pictures or depths.
    """
    if isinstance(recorded, dict) and isinstance(result, dict) and recorded.keys() == result.keys():
        for key, each in recorded.items():
            yield from find_differences(each, result[key], tolerance)
    elif isinstance(recorded, list) and isinstance(result, (list, tuple)) and len(recorded) == len(result):
        for one, other in zip(recorded, result, strict=True):
            yield from find_differences(one, other, tolerance)
    elif isinstance(recorded, bytes) and isinstance(result, bytes) and len(recorded) == len(result):
        if recorded != result and (off := _compute_distance(recorded, result, is_depth=tolerance > 0)) > (
            tolerance or PIXEL_LEVELS
        ):
            yield f"{off:.3f} off"
    elif isinstance(recorded, float) and isinstance(result, float):
        if not (abs(recorded - result) <= tolerance or (math.isnan(recorded) and math.isnan(result))):
            yield f"{result}, recorded {recorded}"
    elif type(recorded) is not type(result) or recorded != result:
        yield f"{result!r:.90}, recorded {recorded!r:.90}"


def _compute_distance(recorded: bytes, result: bytes, *, is_depth: bool) -> float:
    """Return the mean difference of two pictures in grey levels, or the greatest difference of two depths in metres."""
    if not is_depth:
        pictures = (np.frombuffer(each, np.uint8).astype(int) for each in (recorded, result))
        return float(np.abs(np.subtract(*pictures)).mean())
    one, other = (np.frombuffer(each, "<f4") for each in (recorded, result))
    is_at_the_wall = not AT_THE_WALL_M < one.min() < FREE_M
    return 0.0 if is_at_the_wall else float(np.abs(one - other).max())


AT_THE_WALL_M, FREE_M = 0.035, 2.9
"""The least and the greatest recorded depth to compare, in metres. Nearer, the robot bounces off the wall."""

ZMQ_SESSIONS = {"zmq-session.jsonl": default_scene, "zmq-session-2.jsonl": walled_scene}
"""The recorded ZeroMQ sessions and their initial scenes."""

LAST_LINE = 745
"""The last line of a ZeroMQ session to replay. Later requests run Lua scripts, which the double lacks."""

UNUSED = {
    "sim.checkCollision",
    "sim.checkDistance",
    "sim.computeMassAndInertia",
    "sim.getJointVelocity",
    "sim.getObjectOrientation",
    "sim.getVisionSensorDepthBuffer",
    "sim.loadScene",
    "sim.readVisionSensor",
}
"""The functions that were recorded and that no driver calls. The double does not have them."""

EXECUTED, WAIT, END = "_*executed*_", "_*wait*_", "_*end*_"
Message = dict[str, Any]


@dataclass(frozen=True)
class Exchange:
    """A recorded request and its reply. ``waited``: the server has sent a wait message before the reply."""

    line: int
    request: Message
    reply: Message
    waited: bool


def load_zmq_session(file: str) -> Iterator[Exchange]:
    """Read a recorded session, and yield the exchanges to replay."""
    line, request, waited = 0, dict[str, Any](), False
    for number, text in enumerate((RECORDED / file).read_text().splitlines()[:LAST_LINE], start=1):
        message = json.loads(text)
        body = _decode(message["body"])
        if message["dir"] == "request":
            if body["func"] != EXECUTED:
                line, request, waited = number, body, False
        elif body.get("func") == WAIT:
            waited = True
        elif request and request["func"] not in UNUSED:
            yield Exchange(line, request, body, waited)


def _decode(body: Any) -> Any:
    """Decode the body of a recorded message. The table of functions is recorded only once."""
    if isinstance(body, dict):
        if "__bytes__" in body:
            return base64.b64decode(body["__bytes__"])
        return {key: _decode(each) for key, each in body.items()}
    if isinstance(body, list):
        return [_decode(each) for each in body]
    return load_table() if body == "<see sim-info.json>" else body


class ZmqClient:
    """A client that sends one message at a time."""

    def __init__(self, socket: zmq.Socket[bytes]) -> None:
        self._socket, self._uuid = socket, str(uuid.uuid4())

    def exchange_bytes(self, message: bytes) -> Any:
        """Send the bytes of a message, and return its reply."""
        self._socket.send(message)
        return cbor.loads(self._socket.recv())

    def exchange(self, request: Message) -> Any:
        """Send a request, and return its reply. After a request that ends the session, continue as a new client."""
        reply = self.exchange_bytes(cbor.dumps({**request, "uuid": self._uuid}))
        if request["func"] == END:
            self._uuid = str(uuid.uuid4())
        return reply

    def call(self, function: str, *arguments: Any, **more: Any) -> Any:
        """Send a call, and return its first reply, which may be a wait message."""
        return self.exchange({"func": function, "args": list(arguments), **more})

    def finish(self, reply: Any) -> Any:
        """Exchange wait messages until a call ends, and return the last reply."""
        while reply.get("func") == WAIT:
            reply = self.call(EXECUTED)
        return reply


@contextmanager
def connect_clients(port: int, count: int) -> Iterator[list[ZmqClient]]:
    """Connect ZeroMQ clients to a server on this computer."""
    with zmq.Context() as context:
        sockets = [context.socket(zmq.REQ) for _ in range(count)]
        try:
            for socket in sockets:
                socket.linger, socket.rcvtimeo = 0, PATIENCE_MS
                socket.connect(f"tcp://127.0.0.1:{port}")
            yield list(map(ZmqClient, sockets))
        finally:
            for socket in sockets:
                socket.close()


def replay_zmq_session(file: str) -> list[str]:
    """Replay a recorded session on a double with the session's initial scene, and return the differences."""
    with Double(ZMQ_SESSIONS[file]()) as double, connect_clients(double.zmq_port, 1) as (client,):
        return [
            f"line {each.line}, {each.request['func']}: {found}"
            for each in load_zmq_session(file)
            for found in _replay_exchange(client, each)
        ]


def _replay_exchange(client: ZmqClient, exchange: Exchange) -> Iterator[str]:
    name, recorded = exchange.request["func"], exchange.reply
    first = client.exchange(exchange.request)
    reply = client.finish(first)
    if (waited := reply is not first) != exchange.waited:
        yield f"waited: {waited}"
    if name in PARTLY_COMPARED and "ret" in recorded:  # the state of a sensor, or the two objects of a contact
        recorded, reply = ({"ret": each.get("ret", [each])[:1]} for each in (recorded, reply))
    if exchange.request.get("args", [])[:2] != ALL_CONTACTS:
        yield from find_differences(recorded, reply, TOLERANCES.get(name, 0.0))


PARTLY_COMPARED = {"sim.handleVisionSensor", "sim.getContactInfo"}
"""The functions whose first result is compared. The double has no statistics of pictures, and no forces."""

ALL_CONTACTS = [-2, -2]
"""The arguments of a call about all contacts. The double has no contacts with the floor."""

RUNNING_FOR_S = 4.95
"""The simulated time before the first message to the temporary service, in seconds."""


class MessageSteppedService(Service):
    """A service that simulates one time step with each message if no client steps, as in the recordings."""

    def _turn(self, client: Client) -> None:
        super()._turn(client)
        if self._simulator.state.is_advancing and not self._simulator.is_stepped:
            self._simulator.advance()


class TemporaryMessageSteppedService(MessageSteppedService, TemporaryService):
    """A `MessageSteppedService` that ends with the simulation."""


def _create_running_scene() -> Simulator:
    simulator = rover_scene(215)
    with simulator.lock:
        simulator.start()
        simulator.time = RUNNING_FOR_S
    return simulator


LEGACY_SESSIONS = {
    "legacy-calls.json": (coloured_scene, MessageSteppedService),
    "legacy-calls-2.json": (lambda: rover_scene(180), MessageSteppedService),
    "legacy-calls-19999.json": (_create_running_scene, TemporaryMessageSteppedService),
}
"""The recorded legacy sessions, their initial scenes, and their services."""

PARTLY_KNOWN = {"simxGetPingTime": 1, "simxReadProximitySensor": 2}
"""The number of results to compare. The others depend on timing, or are arbitrary without a detection."""


def replay_legacy_session(file: str) -> list[str]:
    """Make the recorded calls on a service with the session's initial scene, and return the differences."""
    create_scene, serve = LEGACY_SESSIONS[file]
    service = serve(create_scene())
    client, previous, begun_ms, differences = -1, "", None, list[str]()
    try:
        for call in json.loads((RECORDED / file).read_text()):
            name, recorded = call["call"], _convert(call["call"], call["result"])
            if name == "simxStart":
                client = simx.simxStart("127.0.0.1", service.port, True, True, PATIENCE_MS, 1)
                continue
            result = _convert(name, _execute_call(client, name, call["args"], recorded))
            if name == "simxGetLastCmdTime" and isinstance(service, TemporaryService):
                begun_ms = result - recorded if begun_ms is None else begun_ms
                result -= begun_ms
            count = 1 if previous == "simxStopSimulation" else PARTLY_KNOWN.get(name)
            if isinstance(recorded, list):
                recorded, result = recorded[:count], list(result)[:count]
            found = find_differences(recorded, result, TOLERANCES.get(name, 0.0)) if recorded is not None else ()
            differences += [f"{name}{call['args']}: {each}" for each in found]
            previous = name
    finally:
        simx.simxFinish(client)
        service.close()
    return differences


def _execute_call(client: int, name: str, arguments: list[Any], recorded: Any) -> Any:
    """Execute a recorded call, and return its result.

    A call about a connection is repeated until the connection has ended.
    """
    function = getattr(simx, name)
    clock, result = MonotonicClock(), function(client, *arguments)
    while name == "simxGetConnectionId" and result != recorded and clock.now() < PATIENCE_MS / 1000:
        result = function(client, *arguments)
    return result


def _convert(name: str, result: Any) -> Any:
    """Convert signed pixels to bytes, and drop repeated errors. A failed stream adds an error with each message."""
    if name == "simxGetVisionSensorImage":
        code, resolution, pixels = result
        return [code, resolution, bytes(pixel & 0xFF for pixel in pixels)]
    if name == "simxGetLastErrors":
        return [result[0], list(dict.fromkeys(result[1]))]
    return result
