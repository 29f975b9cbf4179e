"""Answers about objects: handles, joints, poses, and what a proximity sensor sees."""

from __future__ import annotations

import struct

from tests.doubles.coppeliasim.legacy.codec import Command
from tests.doubles.coppeliasim.legacy.codes import Code
from tests.doubles.coppeliasim.legacy.functions import NOBODY, Functions
from tests.doubles.coppeliasim.legacy.refused import Answers, RefusedError, refusing
from tests.doubles.coppeliasim.scene.poses import Vector

INT = struct.Struct("<i")
FLOAT = struct.Struct("<f")
FLOATS3 = struct.Struct("<3f")
FLOATS6 = struct.Struct("<6f")
TWO_INTS = struct.Struct("<2i")
RELATIVE = struct.Struct("<i3f")
DETECTION = struct.Struct("<b3fi3f")

RUBBISH = DETECTION.pack(0, 0.0, 3.640625, -1.6e-23, 0, -5481547.5, 1.62, -6.1e-12)
"""What the real server sends where nothing is detected: what happens to be in its memory. Only the first byte holds."""


def answers_on_objects(functions: Functions) -> Answers:
    """Return what can be asked about the objects of a scene."""
    objects = Objects(functions)
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


class Objects:
    """The commands that name an object; each returns the data of its reply."""

    def __init__(self, functions: Functions) -> None:
        self._functions = functions

    def handle(self, command: Command) -> bytes:
        with refusing("simGetObjectHandle", INT.pack(NOBODY)):
            return INT.pack(self._functions.handle(text(command.identity)))

    def parent(self, command: Command) -> bytes:
        with refusing("simGetObjectParent", INT.pack(NOBODY)):
            return INT.pack(self._functions.parent(handle(command)))

    def child(self, command: Command) -> bytes:
        with refusing("simGetObjectChild", INT.pack(NOBODY)):
            return INT.pack(self._functions.child(*two_numbers(command)))

    def objects(self, command: Command) -> bytes:
        """Return how many there are of a type, then their handles."""
        handles = self._functions.objects(handle(command))
        return struct.pack(f"<{len(handles) + 1}i", len(handles), *handles)

    def joint_position(self, command: Command) -> bytes:
        with refusing("simGetJointPosition", FLOAT.pack(0.0)):
            return FLOAT.pack(self._functions.joint_position(handle(command)))

    def set_joint_position(self, command: Command) -> bytes:
        with refusing("simSetJointPosition"):
            self._functions.set_joint_position(handle(command), *values(FLOAT, command))
        return b""

    def set_joint_target_velocity(self, command: Command) -> bytes:
        with refusing("simSetJointTargetVelocity"):
            self._functions.set_joint_target_velocity(handle(command), *values(FLOAT, command))
        return b""

    def proximity(self, command: Command) -> bytes:
        """Return the 29 bytes of a reading: a byte 0 or 1, the point, the object's handle, the normal.

        No recording holds a positive one: its layout is the plug-in's (``simxCmd.cpp``, read_proximity_sensor) and the
        official binding's documentation of ``simxReadProximitySensor``. There is no distance: it is the point's norm.
        """
        with refusing("simReadProximitySensor", RUBBISH):
            seen = self._functions.detection(handle(command))
        return DETECTION.pack(1, *seen.point, seen.handle, *seen.normal) if seen else RUBBISH

    def position(self, command: Command) -> bytes:
        with refusing("simGetObjectPosition", FLOATS3.pack(0, 0, 0)):
            return FLOATS3.pack(*self._functions.position(*two_numbers(command)))

    def orientation(self, command: Command) -> bytes:
        with refusing("simGetObjectOrientation", FLOATS3.pack(0, 0, 0)):
            return FLOATS3.pack(*self._functions.orientation(*two_numbers(command)))

    def set_position(self, command: Command) -> bytes:
        relative_to, vector = _relative(command)
        with refusing("simSetObjectPosition"):
            self._functions.set_position(handle(command), relative_to, vector)
        return b""

    def set_orientation(self, command: Command) -> bytes:
        relative_to, angles = _relative(command)
        with refusing("simSetObjectOrientation"):
            self._functions.set_orientation(handle(command), relative_to, angles)
        return b""

    def velocity(self, command: Command) -> bytes:
        """Return the linear, then the angular velocity."""
        with refusing("simGetObjectVelocity", bytes(FLOATS6.size)):
            linear, angular = self._functions.velocity(handle(command))
        return FLOATS6.pack(*linear, *angular)


def handle(command: Command) -> int:
    """Return the handle, or other number, that a command is told apart by."""
    (number,) = values(INT, command, command.identity)
    return int(number)


def two_numbers(command: Command) -> tuple[int, int]:
    """Return the two handles, or the handle and other number, that a command is told apart by."""
    one, other = values(TWO_INTS, command, command.identity)
    return int(one), int(other)


def text(data: bytes) -> str:
    """Return a name: it ends with a zero."""
    return data.split(b"\0")[0].decode(errors="replace")


def values(layout: struct.Struct, command: Command, data: bytes | None = None) -> tuple[float, ...]:
    """Return the numbers in a command's data; the command fails where there are too few bytes for them."""
    data = command.data if data is None else data
    if len(data) < layout.size:
        raise RefusedError
    return layout.unpack_from(data)


def _relative(command: Command) -> tuple[int, Vector]:
    relative_to, x, y, z = values(RELATIVE, command)
    return int(relative_to), (x, y, z)
