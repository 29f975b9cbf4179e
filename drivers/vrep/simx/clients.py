"""The clients that a script has started, by their numbers, as the official binding keeps them for a whole process."""

from __future__ import annotations

import struct
import threading
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from drivers.vrep.message_pump import MessagePump
from drivers.vrep.simx import constants as c
from drivers.vrep.wire.link import Link
from drivers.vrep.wire.messages import Piece
from drivers.vrep.wire.requests import BLOCKING, BUFFER, REMOVE, Request

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
