"""The clients that a script has started, by their numbers, as the official binding keeps them for a whole process."""

from __future__ import annotations

import struct
import threading
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from drivers.vrep.message_pump import MessagePump
from drivers.vrep.simx import constants as c

# ruff: noqa: N802, N803, D103  the official binding's names; its manual says what the short ones do
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import VERSION, Header, Piece, read_nothing
from drivers.vrep.wire.link import Link
from drivers.vrep.wire.requests import BLOCKING, BUFFER, REMOVE, Request
from robotcore.hal.wall_clock import MonotonicClock

MAX_CLIENTS = 255
REPLY_TIMEOUT_S = 5.0
_EXCHANGE_TIMEOUT_S = 5.0
"""A server that loads a scene answers nobody for a while, and the official binding waits."""

_FINISH_TIMEOUT_S = 0.5
_OPMODE_MASK = 0xFF0000

Address = tuple[str, int]


@dataclass(frozen=True)
class Terms:
    """How often a client says something, how long it tries to connect and a blocking call waits, and if it reconnects.

    In seconds.
    """

    period_s: float
    patience_s: float
    reply_timeout_s: float
    reconnects: bool


class Client:
    """One line to a server."""

    def __init__(self, address: Address, terms: Terms) -> None:
        self.address, self._terms = address, terms
        self.last_command_ms = 0
        connect = partial(Link.to, *address, _EXCHANGE_TIMEOUT_S)
        self.mailbox = MessagePump(connect, terms.period_s, terms.patience_s, reconnects=terms.reconnects)

    def ask(self, request: Request[object], operation_mode: int) -> tuple[int, Piece | None]:
        """Do what the operation mode says; return the code and the newest answer, if there is one."""
        mode, delay = operation_mode & _OPMODE_MASK, operation_mode & ~_OPMODE_MASK
        if operation_mode & ~0x7FFFF:
            return c.simx_return_illegal_opmode_flag, None
        if mode == REMOVE:
            return (c.simx_return_ok if self.mailbox.forget(request) else c.simx_return_novalue_flag), None
        code = c.simx_return_ok
        if mode != BUFFER:
            number = self.mailbox.post(request, mode, delay)
            if mode == BLOCKING and not self.mailbox.wait(number, self._terms.reply_timeout_s):
                code |= c.simx_return_timeout_flag
        answer = self.mailbox.newest(request)
        if mode == BLOCKING:
            self.mailbox.forget(request)
        return code | self._judged(answer), answer

    def finish(self) -> None:
        """End it, with all done that it was told."""
        self.mailbox.close(_FINISH_TIMEOUT_S)

    def _judged(self, answer: Piece | None) -> int:
        if answer is None:
            return c.simx_return_novalue_flag
        self.last_command_ms = answer.time_ms
        return c.simx_return_remote_error_flag if answer.is_failed else c.simx_return_ok


class Clients:
    """All clients of a process. Its methods may be called from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._clients: dict[int, Client] = {}

    def get(self, number: int) -> Client | None:
        with self._lock:
            return self._clients.get(number)

    def start(self, address: Address, terms: Terms) -> int:
        """Return a new client's number, -1 if there already is one to that address, or too many."""
        with self._lock:
            number = next((one for one in range(MAX_CLIENTS) if one not in self._clients), -1)
            if number == -1 or any(client.address == address for client in self._clients.values()):
                return -1
            self._clients[number] = Client(address, terms)
            return number

    def finish(self, number: int) -> None:
        """End a client if there is one of that number; -1 ends all."""
        with self._lock:
            numbers = list(self._clients) if number == -1 else [number]
            ended = [self._clients.pop(one) for one in numbers if one in self._clients]
        for client in ended:
            client.finish()


CLIENTS = Clients()


T = TypeVar("T")
U = TypeVar("U")


def send(client: int, request: Request[None], operation_mode: int) -> int:
    """Return the code."""
    if (known := CLIENTS.get(client)) is None:
        return c.simx_return_initialize_error_flag
    return known.ask(request, operation_mode)[0]


def read(client: int, request: Request[T], operation_mode: int, nothing: U) -> tuple[int, T | U]:
    """Return the code and the value, or ``nothing`` where there is none: the official binding's untouched variable."""
    if (known := CLIENTS.get(client)) is None:
        return c.simx_return_initialize_error_flag, nothing
    code, answer = known.ask(request, operation_mode)
    if code or answer is None:
        return code, nothing
    try:
        return code, request.decode(answer.data)
    except (struct.error, ValueError):
        return c.simx_return_local_error_flag, nothing


def read_list(client: int, request: Request[tuple[float, ...]], mode: int, length: int) -> tuple[int, list[float]]:
    """Return the code and a list of so many numbers, zeros where there is no value."""
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
    """Return the number of a new client; -1 if none could connect, or another one has that address.

    A negative time-out is that of blocking calls. Ports below zero, shared memory, are not served.
    """
    host = connectionAddress.decode() if isinstance(connectionAddress, bytes) else str(connectionAddress)
    terms = Terms(
        period_s=max(commThreadCycleInMs, 1) / 1000,
        patience_s=(timeOutInMs if timeOutInMs >= 0 else _CONNECT_TIMEOUT_MS) / 1000,
        reply_timeout_s=-timeOutInMs / 1000 if timeOutInMs < 0 else REPLY_TIMEOUT_S,
        reconnects=not doNotReconnectOnceDisconnected,
    )
    client = CLIENTS.start((host, int(connectionPort)), terms) if 0 <= connectionPort <= 0xFFFF else -1
    known = CLIENTS.get(client)
    if waitUntilConnected and known and not known.mailbox.wait_connected(terms.patience_s):
        CLIENTS.finish(client)
        return -1
    return client


def simxFinish(clientID: int) -> None:
    """End a client, or with -1 all, once the server has done what it was told."""
    CLIENTS.finish(clientID)


def simxGetConnectionId(clientID: int) -> int:
    """Return which connection of this client's it is, from 1; -1 while there is none."""
    client = CLIENTS.get(clientID)
    return client.mailbox.connections if client and client.mailbox.is_connected else -1


def simxGetPingTime(clientID: int) -> tuple[int, int]:
    """Return the code and how many ms the server took over a command, a step of the simulation included."""
    if CLIENTS.get(clientID) is None:
        return c.simx_return_ok, 0
    start = _CLOCK.now()
    code, _ = read(clientID, requests.CLOCK, c.simx_opmode_blocking, 0)
    return code & ~c.simx_return_remote_error_flag, round((_CLOCK.now() - start) * 1000)


def simxGetLastCmdTime(clientID: int) -> int:
    """Return the simulation's time in ms at which the command was done whose answer was last looked at."""
    client = CLIENTS.get(clientID)
    return client.last_command_ms if client else 0


def simxGetInMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and what the newest message says at `simx_headeroffset_…`; -1 and 0 if nothing does."""
    client = CLIENTS.get(clientID)
    if client is None or (server := client.mailbox.server) is None:
        return -1, 0
    info = _info(server).get(infoType)
    return (-1, 0) if info is None else (1, info)


def simxGetOutMessageInfo(clientID: int, infoType: int) -> tuple[int, int]:
    """Return 1 and what the next message will say at `simx_headeroffset_…`; -1 and 0 if nothing does."""
    if infoType == c.simx_headeroffset_version:
        return 1, VERSION
    if infoType == c.simx_headeroffset_client_time:
        return 1, int(_CLOCK.now() * 1000)
    client = CLIENTS.get(clientID)
    return (1, client.mailbox.number) if client and infoType == c.simx_headeroffset_message_id else (-1, 0)


def simxPauseCommunication(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Hold back what is sent, so that it goes out in one message when communication goes on."""
    if (client := CLIENTS.get(clientID)) is None:
        return c.simx_return_initialize_error_flag
    client.mailbox.hold(held=bool(enable))
    return c.simx_return_ok


def simxSynchronous(clientID: int, enable: bool) -> int:  # noqa: FBT001
    """Let the simulation wait for a trigger before each step, or go on by itself."""
    return send(clientID, requests.SYNCHRONOUS_ON if enable else requests.SYNCHRONOUS_OFF, c.simx_opmode_blocking)


def simxSynchronousTrigger(clientID: int) -> int:
    """Let the simulation take one step. It has been taken when a later command is answered."""
    return send(clientID, requests.TRIGGER, c.simx_opmode_blocking)


def simxStartSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.START, operationMode)


def simxPauseSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.PAUSE, operationMode)


def simxStopSimulation(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.STOP, operationMode)


def simxGetLastErrors(clientID: int, operationMode: int) -> tuple[int, list[str]]:
    """Return what went wrong at the server since the last time this was asked, 50 messages at most."""
    return read(clientID, requests.LAST_ERRORS, operationMode, [])


def simxAddStatusbarMessage(clientID: int, message: str | bytes, operationMode: int) -> int:
    return send(clientID, requests.statusbar_message(message), operationMode)


def simxLoadScene(clientID: int, scenePathAndName: str | bytes, options: int, operationMode: int) -> int:
    """Load a scene from the server's disk; scenes of the client's (option bit 0) are not transferred."""
    if options & 1:
        return c.simx_return_local_error_flag
    return send(clientID, requests.of_name("load", 0x3002, scenePathAndName, read_nothing), operationMode)


def simxCloseScene(clientID: int, operationMode: int) -> int:
    return send(clientID, requests.of_nothing("close the scene", 0x0005, read_nothing), operationMode)


def _info(server: Header) -> dict[int, int]:
    return {
        c.simx_headeroffset_version: server.version,
        c.simx_headeroffset_message_id: server.message,
        c.simx_headeroffset_client_time: server.client_time_ms,
        c.simx_headeroffset_server_time: server.server_time_ms,
        c.simx_headeroffset_scene_id: server.scene,
        c.simx_headeroffset_server_state: server.state,
    }
