"""Recorded sessions of a real server, and the messages of their clients.

A file holds the traffic in both directions, chunk by chunk. Repeated idle traffic was removed from one file, with some
messages. The numbers of the remaining messages show the gaps. A missing message was empty, or it had a command whose
reply is recorded; `Session.messages` restores it. If a command was removed with its reply, ``legacy-calls-2.json``
still has the call: see ``LOST``.
"""

from __future__ import annotations

import io
import json
import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from tests.doubles.coppeliasim.legacy.codec import Code, Command, Header, Mode, pack, read_message, unpack
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import (
    Dummy,
    ForceSensor,
    Joint,
    JointMode,
    Primitive,
    ProximitySensor,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Quaternion, Transform, Vector
from tests.doubles.coppeliasim.scene.simulator import Simulator

FOLDER = Path(__file__).parent.parent / "recorded"

PATIENCE = 40
"""The maximum number of messages until an answer. The main loop paused for up to 125 ms, and a message took 5 ms."""

LOST = {
    "legacy-wire-2.jsonl": {
        268: Command(Code.SYNCHRONOUS_NEXT, Mode.BLOCKING),
        284: Command(Code.SYNCHRONOUS_NEXT, Mode.BLOCKING),
    }
}
"""Commands that the recording lacks: two steps after the start. The message numbers are approximate."""

DATA = {Code.SET_JOINT_TARGET_VELOCITY: struct.pack("<f", 1.0)}
"""The data of commands whose message is not in the recording."""

Key = tuple[int, int, bytes]


@dataclass(frozen=True)
class Reply:
    """A reply of the real server. ``answers`` is the number of the last message that it answers."""

    header: Header
    commands: list[Command]
    answers: int


@dataclass
class Session:
    """The messages of a client and the recorded replies."""

    messages: list[bytes]
    replies: list[Reply]


def load_session(name: str) -> Session:
    """Read a recorded session from a file."""
    rows = [json.loads(row) for row in (FOLDER / name).read_text().splitlines()]
    said = {unpack(message)[0].message: message for message in _messages(rows, "client")}
    asked = _CommandLog(said, LOST.get(name, {}))
    replies = [asked.reply(*unpack(message)) for message in _messages(rows, "server")]
    messages = [said.get(number) or asked.message(number) for number in range(max(said) + 1)]
    return Session(messages, [reply for reply in replies if reply.header.message >= 0])


def _messages(rows: list[dict[str, str]], direction: str) -> Iterator[bytes]:
    line = io.BytesIO(b"".join(bytes.fromhex(row["hex"]) for row in rows if row["dir"] == direction))
    size = len(line.getbuffer())
    while line.tell() < size:
        yield read_message(line.read)


class _CommandLog:
    """The commands of each message of a client.

    It inserts the commands that the recording lacks before their answers.
    """

    def __init__(self, sent: dict[int, bytes], lost: dict[int, Command]) -> None:
        self._open = [(number, _key(command)) for number, message in sent.items() for command in unpack(message)[1]]
        self._streams: set[Key] = set()
        self._missing = {number: [command] for number, command in lost.items()}

    def message(self, number: int) -> bytes:
        return pack(Header(number, 0), self._missing.get(number, []))

    def reply(self, header: Header, commands: list[Command]) -> Reply:
        """Return a recorded reply with the number of the last message that it answers."""
        asked = [self._find_message(header.message, command) for command in commands]
        return Reply(header, commands, max((each for each in asked if each is not None), default=header.message))

    def _find_message(self, number: int, command: Command) -> int | None:
        """Return the number of the message that contains a command; None for a stream that continues."""
        key = _key(command)
        is_open = ((n, k) for n, k in self._open if k == key and number - PATIENCE < n <= number)
        if found := next(is_open, None):
            self._open.remove(found)
        elif key in self._streams:
            return None
        else:
            found = (number, key)
            self._missing.setdefault(number, []).append(_request(command))
        if command.mode == Mode.STREAMING:
            self._streams.add(key)
        return found[0]


def _request(reply: Command) -> Command:
    return replace(reply, data=DATA.get(Code(reply.code), b""), status=0, sim_ms=0)


def _key(command: Command) -> Key:
    return command.code, command.mode, command.identity


TO_THE_LEFT: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""The rotation of a wheel's joint. Its z axis points to the robot's left."""
AHEAD: Quaternion = (0.5, 0.5, 0.5, 0.5)
"""The rotation of a forward sensor. Its z axis is the direction of view, and y points up."""


@dataclass(frozen=True)
class Robot:
    """The dimensions of the robot in a recorded session, in metres."""

    at: Vector = (0.0, 0.0, 0.06)
    wheel_radius: float = 0.0325
    casters: int = 2


def first_scene() -> Simulator:
    """Return the scene of ``legacy-wire.jsonl``, which the first ZeroMQ session builds."""
    graph = Graph(first_handle=15)
    _floor_and_robot(graph, Robot((0.03, 0.0, 0.06), 0.04, casters=1))
    graph.add(VisionSensor("v1", width=16, height=12, takes_external_pictures=True))
    ball = Shape("target", primitive=Primitive.SPHEROID, size=(0.2, 0.2, 0.2), colour=(0.0, 1.0, 0.0))
    red = Shape("redLeft", size=(0.1, 0.1, 0.1), colour=(1.0, 0.0, 0.0))
    blue = Shape("blueUp", size=(0.1, 0.1, 0.1), colour=(0.0, 0.0, 1.0))
    for shape, at in ((ball, (1.0, 0.0, 0.1)), (red, (1.0, 0.4, 0.05)), (blue, (1.0, 0.0, 0.45))):
        graph.put(graph.add(shape), Transform(at))
    graph.add(Dummy("cast out"))
    graph.put(graph.add(ProximitySensor("sensingNose")), Transform((0.0, 0.0, 5.0)))
    return Simulator(graph)


def later_scene(first_handle: int) -> Simulator:
    """Return the scene of ``legacy-wire-2.jsonl`` and ``legacy-wire-19999.jsonl``: a robot and a floor."""
    graph = Graph(first_handle)
    _floor_and_robot(graph, Robot())
    return Simulator(graph)


def _floor_and_robot(graph: Graph, robot: Robot) -> None:
    graph.put(graph.add(Shape("floor", size=(6.0, 6.0, 0.1))), Transform((0.0, 0.0, -0.05)))
    body = graph.add(Shape("rover", size=(0.2, 0.12, 0.05), is_static=False, is_respondable=True))
    graph.put(body, Transform(robot.at))
    for name, side in (("left", 1.0), ("right", -1.0)):
        at = Transform((0.0, side * 0.08, robot.wheel_radius), TO_THE_LEFT)
        joint = graph.add(Joint(f"{name}Motor", control=JointMode.VELOCITY), body)
        wheel = graph.add(_round(f"{name}Wheel", robot.wheel_radius), joint)
        graph.put(joint, at)
        graph.put(wheel, at)
    for _ in range(robot.casters):
        caster, link = graph.add(_round("caster", 0.02), body), graph.add(ForceSensor("link"), body)
        graph.move_under(caster, link)
        graph.put(link, Transform((0.1, 0.0, 0.02)))
    camera = graph.add(VisionSensor("camera", width=16, height=12, near=0.02, far=5.0), body)
    graph.put(camera, Transform((robot.at[0] + 0.105, 0.0, 0.1), AHEAD))


def _round(name: str, radius: float) -> Shape:
    size = (2 * radius, 2 * radius, 2 * radius)
    return Shape(name, primitive=Primitive.SPHEROID, size=size, is_static=False, is_respondable=True)
