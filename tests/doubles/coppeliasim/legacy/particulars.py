"""Answers about particulars: the names and types of many objects at once, and the parameters of vision sensors.

No recording holds them. The layout of groups is the plug-in's (``simxCmd.cpp``, ``simx_cmd_get_object_group_data``).
"""

from __future__ import annotations

import struct

from tests.doubles.coppeliasim.legacy.codec import Command
from tests.doubles.coppeliasim.legacy.codes import Code
from tests.doubles.coppeliasim.legacy.functions import Functions
from tests.doubles.coppeliasim.legacy.objects import FLOAT, INT, two_numbers
from tests.doubles.coppeliasim.legacy.refused import Answers, RefusedError, refusing
from tests.doubles.coppeliasim.scene.objects import Thing, VisionSensor

EVERYTHING = 109
NAMES, TYPES = 0, 1
RESOLUTION_X, RESOLUTION_Y, VIEW_ANGLE = 1002, 1003, 1004


def answers_on_particulars(functions: Functions) -> Answers:
    """Return what can be asked of groups of objects, and of parameters of one."""
    particulars = Particulars(functions)
    return {
        Code.GET_OBJECT_GROUP_DATA: particulars.group,
        Code.GET_OBJECT_INT_PARAMETER: particulars.integer,
        Code.GET_OBJECT_FLOAT_PARAMETER: particulars.floating,
    }


class Particulars:
    """The commands that name a type or an object, and what is to be told of it."""

    def __init__(self, functions: Functions) -> None:
        self._graph = functions.simulator.graph

    def group(self, command: Command) -> bytes:
        """Return how many handles, whole numbers, floats and texts there are, then these."""
        kind, what = two_numbers(command)
        things = [thing for thing in self._graph if kind in {EVERYTHING, thing.type}]
        if what == NAMES:
            return _group(things, [], [thing.alias for thing in things])
        if what == TYPES:
            return _group(things, [int(thing.type) for thing in things], [])
        raise RefusedError

    def integer(self, command: Command) -> bytes:
        with refusing("simGetObjectInt32Parameter", INT.pack(0)):
            sensor, number = self._sensor(command)
        if number not in (RESOLUTION_X, RESOLUTION_Y):
            raise RefusedError(None, INT.pack(0))
        return INT.pack(sensor.width if number == RESOLUTION_X else sensor.height)

    def floating(self, command: Command) -> bytes:
        with refusing("simGetObjectFloatParameter", FLOAT.pack(0.0)):
            sensor, number = self._sensor(command)
        if number != VIEW_ANGLE:
            raise RefusedError(None, FLOAT.pack(0.0))
        return FLOAT.pack(sensor.angle)

    def _sensor(self, command: Command) -> tuple[VisionSensor, int]:
        handle, number = two_numbers(command)
        if not isinstance(sensor := self._graph[handle], VisionSensor):
            raise RefusedError
        return sensor, number


def _group(things: list[Thing], numbers: list[int], texts: list[str]) -> bytes:
    whole = [thing.handle for thing in things] + numbers
    counts = (len(things), len(numbers), 0, len(texts))
    return struct.pack(f"<{4 + len(whole)}i", *counts, *whole) + b"".join(text.encode() + b"\0" for text in texts)
