"""The functions of the official binding about clients, connections, and the time and state of the simulation.

As in the official binding, a number identifies each client of a process.
"""
# ruff: noqa: N802, N803  the names of the official binding

from __future__ import annotations

import struct
import threading
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from drivers.vrep.message_pump import MessagePump
from drivers.vrep.simx import constants as c
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import VERSION, Header, Piece, read_nothing
from drivers.vrep.wire.message_socket import MessageSocket
from drivers.vrep.wire.requests import BLOCKING, BUFFER, REMOVE, Request
from robotcore.hal.wall_clock import MonotonicClock

MAX_CLIENTS = 255
REPLY_TIMEOUT_S = 5.0
_EXCHANGE_TIMEOUT_S = 5.0
"""The time limit of an exchange, in seconds. It is long, because a server does not answer while it loads a scene."""

_FINISH_TIMEOUT_S = 0.5
_OPMODE_MASK = 0xFF0000

Address = tuple[str, int]


class Client:
    """One client of a server, as the official binding has it.

    period_s: the period of messages, in seconds.
    connect_timeout_s: the time limit of connecting, in seconds.
    reply_timeout_s: the time limit of a call in blocking mode, in seconds.
    reconnects: whether to connect again after the connection was lost.
    """

    def __init__(
        self, address: Address, period_s: float, connect_timeout_s: float, reply_timeout_s: float, *, reconnects: bool
    ) -> None:
        self.address, self._reply_timeout_s = address, reply_timeout_s
        self.last_command_ms = 0
        connect = partial(MessageSocket.open, *address, _EXCHANGE_TIMEOUT_S)
        self.pump = MessagePump(connect, period_s, connect_timeout_s, reconnects=reconnects)

    def execute(self, request: Request[object], operation_mode: int) -> tuple[int, Piece | None]:
        """Send a request or read its stored answer, and return the return code and the newest answer.

        operation_mode: one of ``simx_opmode_…``, plus its delay or piece size.

        The answer is None if there is none.
        """
        mode, delay = operation_mode & _OPMODE_MASK, operation_mode & ~_OPMODE_MASK
        if operation_mode & ~0x7FFFF:
            return c.simx_return_illegal_opmode_flag, None
        if mode == REMOVE:
            return (c.simx_return_ok if self.pump.take(request) else c.simx_return_novalue_flag), None
        code = c.simx_return_ok
        if mode != BUFFER:
            number = self.pump.post(request, mode, delay)
            if mode == BLOCKING and not self.pump.wait(number, self._reply_timeout_s):
                code |= c.simx_return_timeout_flag
        answer = self.pump.newest(request)
        if mode == BLOCKING:
            self.pump.take(request)
        return code | self._to_return_code(answer), answer

    def finish(self) -> None:
        """Wait until the server has executed the posted commands, and disconnect."""
        self.pump.close(_FINISH_TIMEOUT_S)

    def _to_return_code(self, answer: Piece | None) -> int:
        if answer is None:
            return c.simx_return_novalue_flag
        self.last_command_ms = answer.time_ms
        return c.simx_return_remote_error_flag if answer.is_failed else c.simx_return_ok


class Clients:
    """The clients of a process, by number. Any thread may call the methods."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._clients: dict[int, Client] = {}

    def get(self, number: int) -> Client | None:
        with self._lock:
            return self._clients.get(number)

    def start(self, address: Address, create: Callable[[Address], Client]) -> int:
        """Create a client, and return its number. Return -1 if the address has a client, or if there are too many."""
        with self._lock:
            number = next((one for one in range(MAX_CLIENTS) if one not in self._clients), -1)
            if number == -1 or any(client.address == address for client in self._clients.values()):
                return -1
            self._clients[number] = create(address)
            return number

    def finish(self, number: int) -> None:
        """End the client with a number. The number -1 ends all clients. An unknown number has no effect."""
        with self._lock:
            numbers = list(self._clients) if number == -1 else [number]
            ended = [self._clients.pop(one) for one in numbers if one in self._clients]
        for client in ended:
            client.finish()


CLIENTS = Clients()


T = TypeVar("T")
U = TypeVar("U")


def send(client: int, request: Request[None], operation_mode: int) -> int:
    """Send a command, and return the return code.

    client: the number of the client.
    """
    if (known := CLIENTS.get(client)) is None:
        return c.simx_return_initialize_error_flag
    return known.execute(request, operation_mode)[0]


def read(client: int, request: Request[T], operation_mode: int, default: U) -> tuple[int, T | U]:
    """Send a request, and return the return code and the value of the newest answer.

    client: the number of the client.
    default: the value if there is no answer.
    """
    if (known := CLIENTS.get(client)) is None:
        return c.simx_return_initialize_error_flag, default
    code, answer = known.execute(request, operation_mode)
    if code or answer is None:
        return code, default
    try:
        return code, request.decode(answer.data)
    except (struct.error, ValueError):
        return c.simx_return_local_error_flag, default


_CLOCK = MonotonicClock()
_CONNECT_TIMEOUT_MS = 5000


def simxStart(
    connectionAddress: str | bytes,
    connectionPort: int,
    waitUntilConnected: bool,  # noqa: FBT001
    doNotReconnectOnceDisconnected: bool,  # noqa: FBT001
    timeOutInMs: int,
    commThreadCycleInMs: int,
) -> int:
    """Create a client, and return its number. Return -1 if it cannot connect, or if the address has a client already.

    timeOutInMs: if positive, the time limit of connecting. If negative, its absolute value is the time limit of calls
        in blocking mode.

    A negative port stands for shared memory, which is not supported.
    """
    host = connectionAddress.decode() if isinstance(connectionAddress, bytes) else str(connectionAddress)
    connect_timeout_s = (timeOutInMs if timeOutInMs >= 0 else _CONNECT_TIMEOUT_MS) / 1000
    create = partial(
        Client,
        period_s=max(commThreadCycleInMs, 1) / 1000,
        connect_timeout_s=connect_timeout_s,
        reply_timeout_s=-timeOutInMs / 1000 if timeOutInMs < 0 else REPLY_TIMEOUT_S,
        reconnects=not doNotReconnectOnceDisconnected,
    )
    client = CLIENTS.start((host, int(connectionPort)), create) if 0 <= connectionPort <= 0xFFFF else -1
    known = CLIENTS.get(client)
    if waitUntilConnected and known and not known.pump.wait_connected(connect_timeout_s):
        CLIENTS.finish(client)
        return -1
    return client


def simxFinish(clientID: int) -> None:
    """Wait until the server has executed the posted commands, and end a client. The number -1 ends all clients."""
    CLIENTS.finish(clientID)


def simxGetConnectionId(clientID: int) -> int:
    """Return the number of the client's present connection; -1 without a connection. The first connection is 1."""
    client = CLIENTS.get(clientID)
    return client.pump.connections if client and client.pump.is_connected else -1


def simxGetPingTime(clientID: int) -> tuple[int, int]:
    """Return the return code, and the duration of a request in ms. It includes a time step of the simulation."""
    if CLIENTS.get(clientID) is None:
        return c.simx_return_ok, 0
    start = _CLOCK.now()
    code, _ = read(clientID, requests.CLOCK, c.simx_opmode_blocking, 0)
    return code & ~c.simx_return_remote_error_flag, round((_CLOCK.now() - start) * 1000)


def simxGetLastCmdTime(clientID: int) -> int:
    """Return the simulation's time in ms at which the server has executed the last request of this client."""
    client = CLIENTS.get(clientID)
    return client.last_command_ms if client else 0


def simxGetInMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and a field of the newest reply's header. Return -1 and 0 if there is no reply or no such field.

    infoType: the value of ``simx_headeroffset_…``.
    """
    client = CLIENTS.get(clientID)
    if client is None or (server := client.pump.server) is None:
        return -1, 0
    info = _list_header_fields(server).get(infoType)
    return (-1, 0) if info is None else (1, info)


def simxGetOutMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and a field of the next message's header. Return -1 and 0 if there is no client or no such field.

    infoType: the value of ``simx_headeroffset_…``.
    """
    if infoType == c.simx_headeroffset_version:
        return 1, VERSION
    if infoType == c.simx_headeroffset_client_time:
        return 1, int(_CLOCK.now() * 1000)
    client = CLIENTS.get(clientID)
    return (1, client.pump.number) if client and infoType == c.simx_headeroffset_message_id else (-1, 0)


def simxPauseCommunication(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Pause or resume the exchange of messages. After a pause, one message sends all posted commands."""
    if (client := CLIENTS.get(clientID)) is None:
        return c.simx_return_initialize_error_flag
    client.pump.set_paused(is_paused=bool(enable))
    return c.simx_return_ok


def simxSynchronous(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Set whether the simulation waits for a trigger before each time step, and return the return code."""
    return send(clientID, requests.SYNCHRONOUS_ON if enable else requests.SYNCHRONOUS_OFF, c.simx_opmode_blocking)


def simxSynchronousTrigger(clientID: int) -> int:
    """Trigger one time step, and return the return code. The step has ended when a later call returns."""
    return send(clientID, requests.TRIGGER, c.simx_opmode_blocking)


def simxLoadScene(clientID: int, scenePathAndName: str | bytes, options: int, operationMode: int) -> int:
    """Load a scene from the disk of the server, and return the return code.

    options: if bit 0 is set, the scene is on the disk of the client. This is not supported.
    """
    if options & 1:
        return c.simx_return_local_error_flag
    return send(clientID, requests.build_request("load", 0x3002, read_nothing, scenePathAndName), operationMode)


def _list_header_fields(server: Header) -> dict[int, int]:
    return {
        c.simx_headeroffset_version: server.version,
        c.simx_headeroffset_message_id: server.message,
        c.simx_headeroffset_client_time: server.client_time_ms,
        c.simx_headeroffset_server_time: server.server_time_ms,
        c.simx_headeroffset_scene_id: server.scene,
        c.simx_headeroffset_server_state: server.state,
    }
