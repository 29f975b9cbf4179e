"""How a function of the official binding becomes a request, and its answer what that function returns."""

from __future__ import annotations

import struct
from typing import TypeVar

from drivers.vrep.simx import constants as c
from drivers.vrep.simx.clients import CLIENTS
from drivers.vrep.wire.request import Request

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
