"""The ZeroMQ server of the double."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

import cbor
import zmq

from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.scene import SceneError, Simulator
from tests.doubles.coppeliasim.zmq.functions import (
    NoFunctionError,
    PendingReply,
    SharedState,
    SimFunctions,
    load_table,
)

IDLE_S = 600.0
"""The default time without a message after which the server drops a client, in seconds."""

NAP_S, HELD_NAP_S, HOLD_S = 0.05, 0.001, 0.01
"""The polling period of the socket, this period while a client waits, and the time until a wait message, in seconds."""

WAIT = {"args": {}, "func": "_*wait*_"}
OLD = {"success": False, "error": "The client ZeroMQ remote API version does not match CoppeliaSim's version"}

Reply = dict[str, Any]


@dataclass
class Client:
    """A client of the server. ``waiting`` is its call whose reply is sent later."""

    functions: SimFunctions
    timeout: float
    seen: float
    waiting: PendingReply | None = None


@dataclass(frozen=True)
class HeldMessage:
    """The message of a client whose call waits. The server must answer it before the deadline."""

    route: list[bytes]
    client: Client
    deadline: float


@dataclass
class ZmqServer:
    """Serves a simulator over the ZeroMQ remote API; a context manager.

    port: the port; 0 takes a free one.
    """

    simulator: Simulator
    port: int = 0

    def __post_init__(self) -> None:
        self._shared = SharedState()
        self._clients: dict[str, Client] = {}
        self._held: list[HeldMessage] = []
        self._clock = MonotonicClock()
        self._is_closing = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="ZeroMQ server of a double", daemon=True)

    def __enter__(self) -> ZmqServer:
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
                self._answer_held()
                self._drop_silent()

    def _receive(self, route: list[bytes], message: bytes) -> None:
        try:
            request = cbor.loads(message)
        except Exception as error:  # noqa: BLE001  the package raises any error for invalid bytes
            self._send(route, {"err": str(error)})
            return
        if not isinstance(request, dict) or "uuid" not in request:
            self._send(route, OLD)
        elif request.get("func") == "_*end*_":
            self._drop(request["uuid"])
            self._send(route, {})
        else:
            self._handle(route, self._find_client(request), request)

    def _handle(self, route: list[bytes], client: Client, request: dict[str, Any]) -> None:
        if client.waiting:  # any message counts as ``_*executed*_``
            self._held.append(HeldMessage(route, client, self._clock.now() + HOLD_S))
            return
        try:
            self._send(route, execute_request(client.functions, request))
        except PendingReply as waiting:
            client.waiting = waiting
            self._send(route, WAIT)

    def _answer_held(self) -> None:
        now, held = self._clock.now(), self._held
        self._held = []
        for each in held:
            if each.client.waiting is None or each.client.waiting.is_over(self.simulator):
                each.client.waiting = None
                self._send(each.route, build_reply([]))
            elif now < each.deadline:
                self._held.append(each)
            else:
                self._send(each.route, WAIT)

    def _find_client(self, request: dict[str, Any]) -> Client:
        uuid, now = request["uuid"], self._clock.now()
        if uuid not in self._clients:
            timeout = float(request.get("timeout") or IDLE_S)
            self._clients[uuid] = Client(SimFunctions(self.simulator, self._shared, uuid), timeout, now)
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

    def _send(self, route: list[bytes], reply: Reply) -> None:
        self._socket.send_multipart([*route, cbor.dumps(reply)])


def execute_request(functions: SimFunctions, request: dict[str, Any]) -> Reply:
    """Execute a request, and return the reply. Raises `PendingReply` if the reply must be sent later.

    An error begins with a line number of the server's script, and the function.
    """
    name = request.get("func", "")
    if name == "zmqRemoteApi.require":
        return build_reply([])
    if name == "zmqRemoteApi.info":
        return build_reply([load_table()])
    try:
        return build_reply(functions.call(name, request.get("args") or []))
    except SceneError as error:
        return {"err": f"{error.where or f'354: in {name}'}: {error}"}
    except NoFunctionError as error:
        return {"err": str(error)}
    except (TypeError, ValueError, LookupError, AttributeError) as error:  # arguments of unexpected types
        return {"err": f"354: in {name}: the double makes nothing of these arguments ({error})"}


def build_reply(values: list[Any]) -> Reply:
    """Return the reply with these results. Without results, it has an empty map, as Lua encodes an empty table."""
    return {"ret": values or {}}
