"""The ZeroMQ server of the double."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Any

from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.scene import SceneError, Simulator
from tests.doubles.coppeliasim.zmq.functions import FUNCTIONS
from tests.doubles.coppeliasim.zmq.session import PendingReply, Session, SharedState, table
from tests.doubles.coppeliasim.zmq.wire import dumps, loads

WHERE = "354: in {}"
"""The begin of the server's error messages: a line number of its script, and the function."""

Reply = dict[str, Any]


class NoFunctionError(Exception):
    """No function has this name. A real server does not have it either."""


def execute_request(session: Session, request: dict[str, Any]) -> Reply:
    """Execute a request, and return the reply. Raises `PendingReply` if the reply must be sent later."""
    if text := request.get("eval"):
        return _evaluate(session, text)
    name, args = request.get("func", ""), list(request.get("args") or [])
    try:
        return build_reply(_call(session, name, args))
    except SceneError as error:
        return {"err": f"{getattr(error, 'where', WHERE.format(name))}: {error}"}
    except NoFunctionError as error:
        return {"err": str(error)}
    except (TypeError, ValueError, LookupError, AttributeError) as error:  # arguments of unexpected types
        return {"err": f"{WHERE.format(name)}: the double makes nothing of these arguments ({error})"}


def build_reply(values: list[Any]) -> Reply:
    """Return the reply with these results.

    If there are none, it contains an empty map, as Lua encodes an empty table.
    """
    return {"ret": values or {}}


def _call(session: Session, name: str, args: list[Any]) -> list[Any]:
    if name in session.shared.services:
        return [session.shared.services[name](*args)]
    if name == "zmqRemoteApi.require":
        return _require_module(args)
    if name == "zmqRemoteApi.info":
        return [table()] if args == ["sim"] else [{}]
    module, _, function = name.partition(".")
    if module == "sim" and function in FUNCTIONS:
        return FUNCTIONS[function](session, args)
    if module == "sim" and function in table():
        raise SceneError("the double of the simulator lacks this function; add it to tests/doubles/coppeliasim.")
    raise NoFunctionError(f"No such function: {name}")


def _require_module(args: list[Any]) -> list[Any]:
    if args != ["sim"]:
        raise SceneError(f"the double of the simulator has the module sim only, not {args}.")
    return []


def _evaluate(session: Session, text: str) -> Reply:
    try:
        return build_reply(list(session.shared.scripts.evaluate(text)))
    except SceneError as error:
        return {"err": str(error)}


IDLE_S = 600.0
"""The default time without a message after which the server drops a client, in seconds."""

NAP_S, HELD_NAP_S, HOLD_S = 0.05, 0.001, 0.01
"""The polling period of the socket, this period while a client waits, and the time until a wait message, in seconds."""

WAIT = {"args": {}, "func": "_*wait*_"}
OLD = {"success": False, "error": "The client ZeroMQ remote API version does not match CoppeliaSim's version"}


@dataclass
class Client:
    """A client of the server. ``waiting`` is its call whose reply is sent later."""

    session: Session
    timeout: float
    seen: float
    waiting: PendingReply | None = None


@dataclass(frozen=True)
class WaitingClient:
    """A client whose call waits. The server must send it a message before the deadline."""

    route: list[bytes]
    client: Client
    deadline: float


@dataclass
class ZmqServer:
    """Serves a simulator over the ZeroMQ remote API; a context manager.

    port: the port; 0 takes a free one.
    services: further functions by full name.
    """

    simulator: Simulator
    port: int = 0
    services: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._shared = SharedState(self.simulator, self.services)
        self._clients: dict[str, Client] = {}
        self._held: list[WaitingClient] = []
        self._clock = MonotonicClock()
        self._is_closing = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="ZeroMQ server of a double", daemon=True)

    def __enter__(self) -> ZmqServer:
        import zmq

        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        self._socket.linger = 0
        if self.port:
            self._socket.bind(f"tcp://127.0.0.1:{self.port}")
        else:
            self.port = self._socket.bind_to_random_port("tcp://127.0.0.1")
        self._thread.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._is_closing.set()
        self._thread.join()
        self._socket.close()
        self._context.term()

    def _serve(self) -> None:
        while not self._is_closing.is_set():
            nap = HELD_NAP_S if self._held else NAP_S
            if self._socket.poll(round(nap * 1000)):
                *route, message = self._socket.recv_multipart()
                with self.simulator.lock:
                    self._receive(route, message)
            with self.simulator.lock:
                self._answer_waiting()
                self._drop_silent()

    def _receive(self, route: list[bytes], message: bytes) -> None:
        try:
            request = loads(message)
        except ValueError as error:
            self._send(route, {"err": str(error)})
            return
        if not isinstance(request, dict) or "uuid" not in request:
            self._send(route, OLD)
        elif request.get("func") == "_*end*_":
            self._drop(request["uuid"])
            self._send(route, {})
        else:
            self._handle(route, self._client(request), request)

    def _handle(self, route: list[bytes], client: Client, request: dict[str, Any]) -> None:
        if client.waiting:  # any message counts as ``_*executed*_``
            self._held.append(WaitingClient(route, client, self._clock.now() + HOLD_S))
            return
        try:
            self._send(route, execute_request(client.session, request))
        except PendingReply as waiting:
            client.waiting = waiting
            self._send(route, WAIT)

    def _answer_waiting(self) -> None:
        now, held = self._clock.now(), self._held
        self._held = []
        for each in held:
            if each.client.waiting and not each.client.waiting.is_over(self.simulator):
                if now < each.deadline:
                    self._held.append(each)
                else:
                    self._send(each.route, WAIT)
            else:
                each.client.waiting = None
                self._send(each.route, build_reply([]))

    def _client(self, request: dict[str, Any]) -> Client:
        uuid, now = request["uuid"], self._clock.now()
        if uuid not in self._clients:
            timeout = float(request.get("timeout") or IDLE_S)
            self._clients[uuid] = Client(Session(self.simulator, self._shared, uuid), timeout, now)
        self._clients[uuid].seen = now
        return self._clients[uuid]

    def _drop_silent(self) -> None:
        now = self._clock.now()
        for uuid, client in list(self._clients.items()):
            if now - client.seen > client.timeout:
                self._drop(uuid)

    def _drop(self, uuid: str) -> None:
        self._clients.pop(uuid, None)
        self.simulator.leave(uuid)

    def _send(self, route: list[bytes], reply: dict[str, Any]) -> None:
        self._socket.send_multipart([*route, dumps(reply)])
