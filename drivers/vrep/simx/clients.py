"""The official binding's functions about clients, connections, time and the state of the simulation.

As in the official binding, each client of a process has a number.
"""
# ruff: noqa: N802, N803, D103  the names and short functions of the official binding; its manual explains them

from __future__ import annotations

import struct
import threading
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from drivers.vrep.message_pump import MessagePump
from drivers.vrep.simx import constants as c
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import VERSION, Header, Piece, read_nothing
from drivers.vrep.wire.link import Link
from drivers.vrep.wire.requests import BLOCKING, BUFFER, REMOVE, Request
from robotcore.hal.wall_clock import MonotonicClock

MAX_CLIENTS = 255
REPLY_TIMEOUT_S = 5.0
_EXCHANGE_TIMEOUT_S = 5.0
"""Time limit of a message. It is long, as in the official binding: a server that loads a scene does not answer."""

_FINISH_TIMEOUT_S = 0.5
_OPMODE_MASK = 0xFF0000

Address = tuple[str, int]


@dataclass(frozen=True)
class ClientSettings:
    """The settings of a client."""

    period_s: float
    """The period of messages in seconds."""
    connect_timeout_s: float
    """Time limit of connecting, in seconds."""
    reply_timeout_s: float
    """Time limit of a blocking call, in seconds."""
    reconnects: bool
    """Whether to connect again after the connection was lost."""


class Client:
    """One client of a server."""

    def __init__(self, address: Address, settings: ClientSettings) -> None:
        self.address, self._settings = address, settings
        self.last_command_ms = 0
        connect = partial(Link.open, *address, _EXCHANGE_TIMEOUT_S)
        self.pump = MessagePump(connect, settings.period_s, settings.connect_timeout_s, reconnects=settings.reconnects)

    def execute(self, request: Request[object], operation_mode: int) -> tuple[int, Piece | None]:
        """Handle a request in an operation mode; return the return code and the newest answer, None without one."""
        mode, delay = operation_mode & _OPMODE_MASK, operation_mode & ~_OPMODE_MASK
        if operation_mode & ~0x7FFFF:
            return c.simx_return_illegal_opmode_flag, None
        if mode == REMOVE:
            return (c.simx_return_ok if self.pump.discard(request) else c.simx_return_novalue_flag), None
        code = c.simx_return_ok
        if mode != BUFFER:
            number = self.pump.post(request, mode, delay)
            if mode == BLOCKING and not self.pump.wait(number, self._settings.reply_timeout_s):
                code |= c.simx_return_timeout_flag
        answer = self.pump.newest(request)
        if mode == BLOCKING:
            self.pump.discard(request)
        return code | self._to_return_code(answer), answer

    def finish(self) -> None:
        """Wait until the server has done the posted commands, and disconnect."""
        self.pump.close(_FINISH_TIMEOUT_S)

    def _to_return_code(self, answer: Piece | None) -> int:
        if answer is None:
            return c.simx_return_novalue_flag
        self.last_command_ms = answer.time_ms
        return c.simx_return_remote_error_flag if answer.is_failed else c.simx_return_ok


class Clients:
    """The clients of a process. Any thread may call the methods."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._clients: dict[int, Client] = {}

    def get(self, number: int) -> Client | None:
        with self._lock:
            return self._clients.get(number)

    def start(self, address: Address, settings: ClientSettings) -> int:
        """Start a client and return its number; -1 if the address has a client already, or if there are too many."""
        with self._lock:
            number = next((one for one in range(MAX_CLIENTS) if one not in self._clients), -1)
            if number == -1 or any(client.address == address for client in self._clients.values()):
                return -1
            self._clients[number] = Client(address, settings)
            return number

    def finish(self, number: int) -> None:
        """End the client with this number, if it exists. The number -1 ends all clients."""
        with self._lock:
            numbers = list(self._clients) if number == -1 else [number]
            ended = [self._clients.pop(one) for one in numbers if one in self._clients]
        for client in ended:
            client.finish()


CLIENTS = Clients()


T = TypeVar("T")
U = TypeVar("U")


def send(client: int, request: Request[None], operation_mode: int) -> int:
    """Send a command, and return the return code."""
    if (known := CLIENTS.get(client)) is None:
        return c.simx_return_initialize_error_flag
    return known.execute(request, operation_mode)[0]


def read(client: int, request: Request[T], operation_mode: int, nothing: U) -> tuple[int, T | U]:
    """Return the return code and the value of a request; without a value, return ``nothing`` in its place."""
    if (known := CLIENTS.get(client)) is None:
        return c.simx_return_initialize_error_flag, nothing
    code, answer = known.execute(request, operation_mode)
    if code or answer is None:
        return code, nothing
    try:
        return code, request.decode(answer.data)
    except (struct.error, ValueError):
        return c.simx_return_local_error_flag, nothing


def read_list(client: int, request: Request[tuple[float, ...]], mode: int, length: int) -> tuple[int, list[float]]:
    """Return the return code and a list of ``length`` numbers. Without a value, the numbers are 0."""
    code, values = read(client, request, mode, (0.0,) * length)
    return code, list(values)


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
    """Start a client and return its number; -1 if it cannot connect, or if the address has a client already.

    A positive ``timeOutInMs`` limits connecting; a negative one limits blocking calls. Negative ports, which stand for
    shared memory, are not supported.
    """
    host = connectionAddress.decode() if isinstance(connectionAddress, bytes) else str(connectionAddress)
    settings = ClientSettings(
        period_s=max(commThreadCycleInMs, 1) / 1000,
        connect_timeout_s=(timeOutInMs if timeOutInMs >= 0 else _CONNECT_TIMEOUT_MS) / 1000,
        reply_timeout_s=-timeOutInMs / 1000 if timeOutInMs < 0 else REPLY_TIMEOUT_S,
        reconnects=not doNotReconnectOnceDisconnected,
    )
    client = CLIENTS.start((host, int(connectionPort)), settings) if 0 <= connectionPort <= 0xFFFF else -1
    known = CLIENTS.get(client)
    if waitUntilConnected and known and not known.pump.wait_connected(settings.connect_timeout_s):
        CLIENTS.finish(client)
        return -1
    return client


def simxFinish(clientID: int) -> None:
    """End a client, or with -1 all clients, after the server has done the posted commands."""
    CLIENTS.finish(clientID)


def simxGetConnectionId(clientID: int) -> int:
    """Return the number of the client's present connection, from 1; -1 without a connection."""
    client = CLIENTS.get(clientID)
    return client.pump.connections if client and client.pump.is_connected else -1


def simxGetPingTime(clientID: int) -> tuple[int, int]:
    """Return the return code, and the time of a round trip in ms. This includes a time step of the simulation."""
    if CLIENTS.get(clientID) is None:
        return c.simx_return_ok, 0
    start = _CLOCK.now()
    code, _ = read(clientID, requests.CLOCK, c.simx_opmode_blocking, 0)
    return code & ~c.simx_return_remote_error_flag, round((_CLOCK.now() - start) * 1000)


def simxGetLastCmdTime(clientID: int) -> int:
    """Return the simulation's time in ms, from the newest answer that a call has returned."""
    client = CLIENTS.get(clientID)
    return client.last_command_ms if client else 0


def simxGetInMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and the field at ``simx_headeroffset_…`` of the newest message; -1 and 0 if there is none."""
    client = CLIENTS.get(clientID)
    if client is None or (server := client.pump.server) is None:
        return -1, 0
    info = _list_header_fields(server).get(infoType)
    return (-1, 0) if info is None else (1, info)


def simxGetOutMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and the field at ``simx_headeroffset_…`` of the next message; -1 and 0 if there is none."""
    if infoType == c.simx_headeroffset_version:
        return 1, VERSION
    if infoType == c.simx_headeroffset_client_time:
        return 1, int(_CLOCK.now() * 1000)
    client = CLIENTS.get(clientID)
    return (1, client.pump.number) if client and infoType == c.simx_headeroffset_message_id else (-1, 0)


def simxPauseCommunication(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Pause or resume sending. One message sends all commands that were posted during a pause."""
    if (client := CLIENTS.get(clientID)) is None:
        return c.simx_return_initialize_error_flag
    client.pump.set_paused(is_paused=bool(enable))
    return c.simx_return_ok


def simxSynchronous(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Set whether the simulation waits for a trigger before each time step. Otherwise it runs by itself."""
    return send(clientID, requests.SYNCHRONOUS_ON if enable else requests.SYNCHRONOUS_OFF, c.simx_opmode_blocking)


def simxSynchronousTrigger(clientID: int) -> int:
    """Trigger one time step. When a later command is answered, the time step is done."""
    return send(clientID, requests.TRIGGER, c.simx_opmode_blocking)


def simxStartSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.START, operationMode)


def simxPauseSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.PAUSE, operationMode)


def simxStopSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.STOP, operationMode)


def simxGetLastErrors(clientID: int, operationMode: int) -> tuple[int, list[str]]:
    """Return the code and the server's errors since the last call, at most 50."""
    return read(clientID, requests.LAST_ERRORS, operationMode, [])


def simxAddStatusbarMessage(clientID: int, message: str | bytes, operationMode: int) -> int:
    return send(clientID, requests.statusbar_message(message), operationMode)


def simxLoadScene(clientID: int, scenePathAndName: str | bytes, options: int, operationMode: int) -> int:
    """Load a scene from the server's disk. A transfer from the client's disk (bit 0 of options) is not supported."""
    if options & 1:
        return c.simx_return_local_error_flag
    return send(clientID, requests.named_request("load", 0x3002, scenePathAndName, read_nothing), operationMode)


def simxCloseScene(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.simulator_request("close the scene", 0x0005, read_nothing), operationMode)


def _list_header_fields(server: Header) -> dict[int, int]:
    return {
        c.simx_headeroffset_version: server.version,
        c.simx_headeroffset_message_id: server.message,
        c.simx_headeroffset_client_time: server.client_time_ms,
        c.simx_headeroffset_server_time: server.server_time_ms,
        c.simx_headeroffset_scene_id: server.scene,
        c.simx_headeroffset_server_state: server.state,
    }
