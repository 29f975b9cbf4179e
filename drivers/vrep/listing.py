"""What there is in a scene, and how its vision sensors see."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

from drivers.vrep.wire.request import Request
from drivers.vrep.wire.requests import of_handles
from drivers.vrep.wire.values import read_float, read_int

EVERYTHING = 109
"""All objects of a scene: ``sim_appobj_object_type``."""

NAMES_OF, TYPES_OF = 0, 1
"""What is to be told of a group of objects."""

RESOLUTION_X, RESOLUTION_Y, VIEW_ANGLE = 1002, 1003, 1004


class Group(NamedTuple):
    """What a server tells of many objects at once: their handles, and whole numbers or texts, one of each."""

    handles: tuple[int, ...]
    numbers: tuple[int, ...]
    texts: tuple[str, ...]


def read_group(data: memoryview) -> Group:
    """Return the four counts' worth of handles, whole numbers, floats (which are left out), and texts.

    As ``simxGetObjectGroupData`` in the maker's extApi.c reads them.
    """
    handles, numbers, floats, texts = struct.unpack_from("<4i", data)
    if min(handles, numbers, floats, texts) < 0:
        raise ValueError("a count below zero")
    whole = struct.unpack_from(f"<{handles + numbers}i", data, 16)
    rest = bytes(data[16 + 4 * (handles + numbers + floats) :])
    words = tuple(part.decode("utf-8", "replace") for part in rest.split(b"\0")[:texts])
    return Group(whole[:handles], whole[handles:], words)


NAMES: Request[Group] = of_handles("name the objects of the scene", 0x200C, EVERYTHING, NAMES_OF, read_group)
TYPES: Request[Group] = of_handles("tell the types of the scene's objects", 0x200C, EVERYTHING, TYPES_OF, read_group)


def columns(sensor: int) -> Request[int]:
    """How many pixels wide a vision sensor's picture is."""
    return _parameter(sensor, 0x2008, RESOLUTION_X, read_int)


def rows(sensor: int) -> Request[int]:
    """How many pixels high a vision sensor's picture is."""
    return _parameter(sensor, 0x2008, RESOLUTION_Y, read_int)


def view_angle(sensor: int) -> Request[float]:
    """The angle that the longer side of a vision sensor's picture takes in, in rad."""
    return _parameter(sensor, 0x2007, VIEW_ANGLE, read_float)


def _parameter(sensor: int, command: int, number: int, decode: Any) -> Request[Any]:
    return of_handles("tell a parameter of vision sensor", command, sensor, number, decode)
