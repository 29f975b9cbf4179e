"""The recorded ZeroMQ sessions: requests and replies.

``_*wait*_`` and ``_*executed*_`` are dropped, because their number depends on timing. An exchange records that its call
waited.
"""

from __future__ import annotations

import base64
import json
import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.replaying.comparison import (
    ANYTHING,
    AT_THE_WALL,
    CONTACT,
    CONTACT_M,
    EXACT,
    TOLERANCES,
    Tolerance,
    find_differences,
)
from tests.doubles.coppeliasim.scenes import default_scene
from tests.doubles.coppeliasim.scenes.parts import second_scene
from tests.doubles.coppeliasim.zmq.session import table
from tests.doubles.coppeliasim.zmq.wire import dumps, loads

if TYPE_CHECKING:
    import zmq


RECORDED = Path(__file__).parents[1] / "recorded"
EXECUTED, WAIT = "_*executed*_", "_*wait*_"
TABLE_REFERENCE = "<see sim-info.json>"

Message = dict[str, Any]


@dataclass(frozen=True)
class Exchange:
    """A recorded request and its reply. ``raw`` has the bytes of the reply if the recording contains them."""

    line: int
    request: Message
    reply: Message
    waited: bool
    raw: bytes | None

    @property
    def name(self) -> str:
        """The called function, or ``eval``."""
        return str(self.request.get("func", "eval"))


def load_session(file: str) -> list[Exchange]:
    """Read a recorded session, and return its exchanges in order."""
    return list(_exchanges(_messages(file)))


def _messages(file: str) -> Iterator[tuple[int, Message]]:
    for number, text in enumerate((RECORDED / file).read_text().splitlines(), start=1):
        yield number, json.loads(text)


def _exchanges(messages: Iterator[tuple[int, Message]]) -> Iterator[Exchange]:
    request, waited = (0, dict[str, Any]()), False
    for number, message in messages:
        body = _decode(message["body"])
        if message["dir"] == "request":
            if body.get("func") != EXECUTED:
                request, waited = (number, body), False
        elif body.get("func") == WAIT:
            waited = True
        elif request[0]:
            raw = base64.b64decode(message["raw_b64"]) if "raw_b64" in message else None
            yield Exchange(*request, body, waited, raw)


def _decode(body: Any) -> Any:
    """Decode the body of a recorded message. The table of functions is recorded only once."""
    if isinstance(body, dict):
        if "__bytes__" in body:
            return base64.b64decode(body["__bytes__"])
        return {key: _decode(each) for key, each in body.items()}
    if isinstance(body, list):
        return [_decode(each) for each in body]
    return table() if body == TABLE_REFERENCE else body


SESSIONS = {"zmq-session.jsonl": default_scene, "zmq-session-2.jsonl": second_scene}
"""The recorded sessions and their initial scenes."""

TIMEOUT_MS = 5000
END_SESSION = "_*end*_"
HANDLED, LEAST_DEPTH = "sim.handleVisionSensor", 4


@dataclass(frozen=True)
class ReplayedReply:
    """A reply to a sent request, whether the call waited, and the bytes of the reply."""

    reply: Any
    waited: bool
    raw: bytes


class ReplayClient:
    """A client that sends recorded requests. After a request that ends the session, it continues as a new client."""

    def __init__(self, socket: zmq.Socket[bytes]) -> None:
        self._socket = socket
        self._socket.rcvtimeo = TIMEOUT_MS
        self._uuid = str(uuid.uuid4())

    def send(self, request: dict[str, Any]) -> ReplayedReply:
        """Send a request, and return its final reply."""
        raw = self._exchange(request)
        waited = False
        while (reply := loads(raw)).get("func") == WAIT:
            waited = True
            raw = self._exchange({"func": EXECUTED, "args": [], "argsL": 0})
        if request.get("func") == END_SESSION:
            self._uuid = str(uuid.uuid4())
        return ReplayedReply(reply, waited, raw)

    def _exchange(self, request: dict[str, Any]) -> bytes:
        self._socket.send(dumps({**request, "uuid": self._uuid}))
        return self._socket.recv()


def replay_on_double(file: str) -> list[str]:
    """Replay a recorded session on a double with the session's initial scene, and return the differences."""
    with Double(SESSIONS[file]()) as double:
        return replay(load_session(file), double.zmq_port)


def replay(exchanges: Sequence[Exchange], port: int) -> list[str]:
    """Replay exchanges on a server, and return the differences between its replies and the recorded ones."""
    import zmq

    with zmq.Context() as context, context.socket(zmq.REQ) as socket:
        socket.linger = 0
        socket.connect(f"tcp://127.0.0.1:{port}")
        client = ReplayClient(socket)
        return [
            f"line {each.line}, {each.name}: {found}" for each in exchanges for found in _compare_exchange(client, each)
        ]


def _compare_exchange(client: ReplayClient, exchange: Exchange) -> Iterator[str]:
    reply = client.send(exchange.request)
    if reply.waited != exchange.waited:
        yield f"waited: {reply.waited}, recorded {exchange.waited}"
    if exchange.name == CONTACT:
        yield from _compare_contacts(exchange.reply["ret"], reply.reply.get("ret", reply.reply))
        return
    tolerance = ANYTHING if _is_at_the_wall(exchange) else TOLERANCES.get(exchange.name, EXACT)
    yield from find_differences(exchange.reply, reply.reply, tolerance)
    if tolerance is EXACT and exchange.raw not in {None, reply.raw}:
        yield f"{reply.raw.hex()}, recorded {exchange.raw.hex() if exchange.raw else ''}"


def _is_at_the_wall(exchange: Exchange) -> bool:
    """Return whether the exchange handles a sensor that the robot had pushed against the wall."""
    is_handled = exchange.name == HANDLED and "ret" in exchange.reply
    return is_handled and exchange.reply["ret"][1][LEAST_DEPTH] < AT_THE_WALL


def _compare_contacts(recorded: Any, reply: Any) -> Iterator[str]:
    yield from find_differences(recorded[:1], reply[:1], where="objects")
    yield from find_differences(recorded[1:2], reply[1:2], Tolerance(CONTACT_M), where="where")
    yield from find_differences([len(each) for each in recorded], [len(each) for each in reply], where="lengths")
    yield from find_differences(recorded[3:], reply[3:], Tolerance(1e-6), where="normal")
