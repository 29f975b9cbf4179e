"""The handlers of commands about objects, and the error of a refused command."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tests.doubles.coppeliasim.legacy.codec import Code, Command
from tests.doubles.coppeliasim.legacy.functions import WORLD, Functions
from tests.doubles.coppeliasim.scene.objects import Node, SceneError, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Vector

CommandHandler = Callable[[Command], bytes]
"""A function that executes a command, and returns the data of the answer.

It raises RefusedError to refuse the command.
"""

CommandHandlers = dict[int, CommandHandler]
"""CommandHandlers by the number of the command."""


class RefusedError(Exception):
    """A command failed.

    The answer contains the error bit and ``data``. ``text`` is added to the client's error messages.
    """

    def __init__(self, text: str | None = None, data: bytes = b"") -> None:
        super().__init__(text)
        self.text, self.data = text, data


@contextmanager
def convert_refusals(function: str, data: bytes = b"") -> Iterator[None]:
    """Return a context manager that converts SceneError to RefusedError. The error names ``function``."""
    try:
        yield
    except SceneError as error:
        raise RefusedError(f"{error} ({function})", data) from error


INT = struct.Struct("<i")
FLOAT = struct.Struct("<f")
FLOATS3 = struct.Struct("<3f")
FLOATS6 = struct.Struct("<6f")
TWO_INTS = struct.Struct("<2i")
RELATIVE = struct.Struct("<i3f")
DETECTION = struct.Struct("<b3fi3f")

NO_DETECTION = DETECTION.pack(0, 0.0, 3.640625, -1.6e-23, 0, -5481547.5, 1.62, -6.1e-12)
"""The data that the real server has sent without a detection. Only the first byte is valid."""


def create_object_handlers(functions: Functions) -> CommandHandlers:
    """Return the handlers of commands about objects."""
    objects = ObjectCommands(functions)
    return {
        Code.GET_OBJECT_HANDLE: objects.handle,
        Code.GET_OBJECT_PARENT: objects.parent,
        Code.GET_OBJECT_CHILD: objects.child,
        Code.GET_OBJECTS: objects.objects,
        Code.GET_JOINT_POSITION: objects.joint_position,
        Code.SET_JOINT_POSITION: objects.set_joint_position,
        Code.SET_JOINT_TARGET_VELOCITY: objects.set_joint_target_velocity,
        Code.READ_PROXIMITY_SENSOR: objects.proximity,
        Code.GET_OBJECT_POSITION: objects.position,
        Code.GET_OBJECT_ORIENTATION: objects.orientation,
        Code.GET_OBJECT_VELOCITY: objects.velocity,
        Code.SET_OBJECT_POSITION: objects.set_position,
        Code.SET_OBJECT_ORIENTATION: objects.set_orientation,
    }


class ObjectCommands:
    """The handlers of commands about one object. Each method returns the data of the answer."""

    def __init__(self, functions: Functions) -> None:
        self._functions = functions

    def handle(self, command: Command) -> bytes:
        with convert_refusals("simGetObjectHandle", INT.pack(WORLD)):
            return INT.pack(self._functions.handle(text(command.identity)))

    def parent(self, command: Command) -> bytes:
        with convert_refusals("simGetObjectParent", INT.pack(WORLD)):
            return INT.pack(self._functions.parent(handle(command)))

    def child(self, command: Command) -> bytes:
        with convert_refusals("simGetObjectChild", INT.pack(WORLD)):
            return INT.pack(self._functions.child(*two_numbers(command)))

    def objects(self, command: Command) -> bytes:
        """Return the number of objects of a type, and then their handles."""
        handles = self._functions.objects(handle(command))
        return struct.pack(f"<{len(handles) + 1}i", len(handles), *handles)

    def joint_position(self, command: Command) -> bytes:
        with convert_refusals("simGetJointPosition", FLOAT.pack(0.0)):
            return FLOAT.pack(self._functions.joint_position(handle(command)))

    def set_joint_position(self, command: Command) -> bytes:
        with convert_refusals("simSetJointPosition"):
            self._functions.set_joint_position(handle(command), *values(FLOAT, command))
        return b""

    def set_joint_target_velocity(self, command: Command) -> bytes:
        with convert_refusals("simSetJointTargetVelocity"):
            self._functions.set_joint_target_velocity(handle(command), *values(FLOAT, command))
        return b""

    def proximity(self, command: Command) -> bytes:
        """Return the 29 bytes of a reading: a byte 0 or 1, the point, the object's handle, the normal.

        No recording has a detection. Sources: the plug-in (``simxCmd.cpp``, read_proximity_sensor) and the
        official binding's documentation of ``simxReadProximitySensor``. The distance is the norm of the point.
        """
        with convert_refusals("simReadProximitySensor", NO_DETECTION):
            seen = self._functions.detection(handle(command))
        return DETECTION.pack(1, *seen.point, seen.handle, *seen.normal) if seen else NO_DETECTION

    def position(self, command: Command) -> bytes:
        with convert_refusals("simGetObjectPosition", FLOATS3.pack(0, 0, 0)):
            return FLOATS3.pack(*self._functions.position(*two_numbers(command)))

    def orientation(self, command: Command) -> bytes:
        with convert_refusals("simGetObjectOrientation", FLOATS3.pack(0, 0, 0)):
            return FLOATS3.pack(*self._functions.orientation(*two_numbers(command)))

    def set_position(self, command: Command) -> bytes:
        relative_to, vector = _relative(command)
        with convert_refusals("simSetObjectPosition"):
            self._functions.set_position(handle(command), relative_to, vector)
        return b""

    def set_orientation(self, command: Command) -> bytes:
        relative_to, angles = _relative(command)
        with convert_refusals("simSetObjectOrientation"):
            self._functions.set_orientation(handle(command), relative_to, angles)
        return b""

    def velocity(self, command: Command) -> bytes:
        """Return the linear velocity, and then the angular velocity."""
        with convert_refusals("simGetObjectVelocity", bytes(FLOATS6.size)):
            linear, angular = self._functions.velocity(handle(command))
        return FLOATS6.pack(*linear, *angular)


def handle(command: Command) -> int:
    """Return the handle, or another number, in the key of a command."""
    (number,) = values(INT, command, command.identity)
    return int(number)


def two_numbers(command: Command) -> tuple[int, int]:
    """Return the two handles, or a handle and another number, in the key of a command."""
    one, other = values(TWO_INTS, command, command.identity)
    return int(one), int(other)


def text(data: bytes) -> str:
    """Decode a text up to its zero byte."""
    return data.split(b"\0")[0].decode(errors="replace")


def values(layout: struct.Struct, command: Command, data: bytes | None = None) -> tuple[float, ...]:
    """Decode the numbers in a command's data. Raises RefusedError if there are too few bytes."""
    data = command.data if data is None else data
    if len(data) < layout.size:
        raise RefusedError
    return layout.unpack_from(data)


def _relative(command: Command) -> tuple[int, Vector]:
    relative_to, x, y, z = values(RELATIVE, command)
    return int(relative_to), (x, y, z)


EVERYTHING = 109
NAMES, TYPES = 0, 1
RESOLUTION_X, RESOLUTION_Y, VIEW_ANGLE = 1002, 1003, 1004


def create_group_handlers(functions: Functions) -> CommandHandlers:
    """Return the handlers of commands about groups of objects, and about parameters of one object."""
    particulars = GroupCommands(functions)
    return {
        Code.GET_OBJECT_GROUP_DATA: particulars.group,
        Code.GET_OBJECT_INT_PARAMETER: particulars.integer,
        Code.GET_OBJECT_FLOAT_PARAMETER: particulars.floating,
    }


class GroupCommands:
    """The handlers of commands about groups of objects, and about parameters of one object."""

    def __init__(self, functions: Functions) -> None:
        self._graph = functions.simulator.graph

    def group(self, command: Command) -> bytes:
        """Return the counts of handles, integers, floats and texts, and then these values."""
        kind, what = two_numbers(command)
        nodes = [node for node in self._graph if kind in {EVERYTHING, node.type}]
        if what == NAMES:
            return _group(nodes, [], [node.alias for node in nodes])
        if what == TYPES:
            return _group(nodes, [int(node.type) for node in nodes], [])
        raise RefusedError

    def integer(self, command: Command) -> bytes:
        with convert_refusals("simGetObjectInt32Parameter", INT.pack(0)):
            sensor, number = self._sensor(command)
        if number not in (RESOLUTION_X, RESOLUTION_Y):
            raise RefusedError(None, INT.pack(0))
        return INT.pack(sensor.width if number == RESOLUTION_X else sensor.height)

    def floating(self, command: Command) -> bytes:
        with convert_refusals("simGetObjectFloatParameter", FLOAT.pack(0.0)):
            sensor, number = self._sensor(command)
        if number != VIEW_ANGLE:
            raise RefusedError(None, FLOAT.pack(0.0))
        return FLOAT.pack(sensor.angle)

    def _sensor(self, command: Command) -> tuple[VisionSensor, int]:
        handle, number = two_numbers(command)
        if not isinstance(sensor := self._graph[handle], VisionSensor):
            raise RefusedError
        return sensor, number


def _group(nodes: list[Node], numbers: list[int], texts: list[str]) -> bytes:
    whole = [node.handle for node in nodes] + numbers
    counts = (len(nodes), len(numbers), 0, len(texts))
    return struct.pack(f"<{4 + len(whole)}i", *counts, *whole) + b"".join(text.encode() + b"\0" for text in texts)
