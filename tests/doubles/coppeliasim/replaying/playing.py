"""Plays recorded requests to a server over a socket, and compares the replies."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.replaying.comparing import differences
from tests.doubles.coppeliasim.replaying.sessions import EXECUTED, WAIT, Exchange, session
from tests.doubles.coppeliasim.replaying.tolerances import (
    ANYTHING,
    AT_THE_WALL,
    CONTACT,
    CONTACT_M,
    EXACT,
    TOLERANCES,
    Tolerance,
)
from tests.doubles.coppeliasim.scenes import default_scene
from tests.doubles.coppeliasim.scenes.recorded import second_scene
from tests.doubles.coppeliasim.zmq.wire import dumps, loads

if TYPE_CHECKING:
    import zmq

SESSIONS = {"zmq-session.jsonl": default_scene, "zmq-session-2.jsonl": second_scene}
"""The recorded sessions, and the scenes that they begin with."""

PATIENCE_MS = 5000
LEFT = "_*end*_"
HANDLED, LEAST_DEPTH = "sim.handleVisionSensor", 4


@dataclass(frozen=True)
class Answer:
    """What a server replied, whether the call waited, and the reply as it was sent."""

    reply: Any
    waited: bool
    raw: bytes


class Player:
    """A client that says what it is told to say; after it has left, it is another one."""

    def __init__(self, socket: zmq.Socket[bytes]) -> None:
        self._socket = socket
        self._socket.rcvtimeo = PATIENCE_MS
        self._uuid = str(uuid.uuid4())

    def ask(self, request: dict[str, Any]) -> Answer:
        """Return the reply to a request, once it no longer has to wait."""
        raw = self._exchange(request)
        waited = False
        while (reply := loads(raw)).get("func") == WAIT:
            waited = True
            raw = self._exchange({"func": EXECUTED, "args": [], "argsL": 0})
        if request.get("func") == LEFT:
            self._uuid = str(uuid.uuid4())
        return Answer(reply, waited, raw)

    def _exchange(self, request: dict[str, Any]) -> bytes:
        self._socket.send(dumps({**request, "uuid": self._uuid}))
        return self._socket.recv()


def play_to_a_double(file: str) -> list[str]:
    """Return where a double that begins as the recorded server did differs from it."""
    with Double(SESSIONS[file]()) as double:
        return play(session(file), double.zmq_port)


def play(exchanges: Sequence[Exchange], port: int) -> list[str]:
    """Return where the replies of a server differ from those recorded, a line each."""
    import zmq

    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        socket.linger = 0
        socket.connect(f"tcp://127.0.0.1:{port}")
        player = Player(socket)
        return [f"line {each.line}, {each.name}: {found}" for each in exchanges for found in _played(player, each)]


def _played(player: Player, exchange: Exchange) -> Iterator[str]:
    reply = player.ask(exchange.request)
    if reply.waited != exchange.waited:
        yield f"waited: {reply.waited}, recorded {exchange.waited}"
    if exchange.name == CONTACT:
        yield from _in_contacts(exchange.reply["ret"], reply.reply.get("ret", reply.reply))
        return
    tolerance = ANYTHING if _is_at_the_wall(exchange) else TOLERANCES.get(exchange.name, EXACT)
    yield from differences(exchange.reply, reply.reply, tolerance)
    if tolerance is EXACT and exchange.raw not in {None, reply.raw}:
        yield f"{reply.raw.hex()}, recorded {exchange.raw.hex() if exchange.raw else ''}"


def _is_at_the_wall(exchange: Exchange) -> bool:
    """Return whether a sensor was handled that the robot had pushed against the wall."""
    is_handled = exchange.name == HANDLED and "ret" in exchange.reply
    return is_handled and exchange.reply["ret"][1][LEAST_DEPTH] < AT_THE_WALL


def _in_contacts(recorded: Any, reply: Any) -> Iterator[str]:
    yield from differences(recorded[:1], reply[:1], where="who")
    yield from differences(recorded[1:2], reply[1:2], Tolerance(CONTACT_M), where="where")
    yield from differences([len(each) for each in recorded], [len(each) for each in reply], where="lengths")
    yield from differences(recorded[3:], reply[3:], Tolerance(1e-6), where="normal")
