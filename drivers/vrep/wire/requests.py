"""Requests of the legacy remote API: commands, and the functions that decode their answers."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from drivers.vrep.wire.codec import (
    Piece,
    Pixels,
    Proximity,
    encode_command,
    floats_reader,
    pack_floats,
    pack_ints,
    pack_text,
    read_colour,
    read_float,
    read_grey,
    read_group,
    read_int,
    read_nothing,
    read_proximity,
)
from drivers.vrep.wire.errors import ProtocolError, RefusedError

T_co = TypeVar("T_co", covariant=True)

ONESHOT = 0x000000
BLOCKING = 0x010000
STREAMING = 0x020000
DISCONTINUE = 0x050000
BUFFER = 0x060000
REMOVE = 0x070000

Identity = tuple[int, bytes]
"""The number of a command, and its key. A command replaces a queued command with the same identity."""


@dataclass(frozen=True)
class Request(Generic[T_co]):
    """A command for the server, and the function that decodes its answer.

    >>> joint_position(17).action
    'read the position of joint 17'
    """

    action: str
    """The words that name the action of the server in error messages: a verb and its object."""
    command: int
    """The number of the command."""
    key: bytes
    """The handles or names of the objects that the command is about, encoded."""
    data: bytes
    """The arguments of the command, encoded."""
    decode: Callable[[memoryview], T_co] = field(compare=False)
    """The function that decodes the data of the answer. It raises struct.error or ValueError if the data is invalid."""

    @property
    def identity(self) -> Identity:
        return self.command, self.key

    def encode(self, mode: int = ONESHOT, delay: int = 0) -> bytes:
        """Encode the request as a command of a message. For the parameters see `encode_command`."""
        return encode_command(self.command, mode, delay, self.key, self.data)

    def read(self, answer: Piece) -> T_co:
        """Decode an answer to this request, and return its value.

        Raises RefusedError if the server could not execute the request, and ProtocolError if the data is invalid.
        """
        if answer.is_failed:
            raise RefusedError(f"the simulator refused to {self.action}", action=self.action)
        try:
            return self.decode(answer.data)
        except (struct.error, ValueError) as error:
            raise ProtocolError(f"{len(answer.data)} bytes in the answer to the request to {self.action}") from error


T = TypeVar("T")


def build_request(
    action: str, command: int, decode: Callable[[memoryview], T], *key: int | str | bytes, data: bytes = b""
) -> Request[T]:
    """Return a request.

    action, command, decode, data: see `Request`. The first part of the key is appended to ``action``.
    key: the handles, parameter numbers or names that the command is about.
    """
    subjects = [repr(part) if isinstance(part, (str, bytes)) else str(part) for part in key[:1]]
    encoded = [pack_text(part) if isinstance(part, (str, bytes)) else pack_ints(part) for part in key]
    return Request(" ".join([action, *subjects]), command, b"".join(encoded), data, decode)


SYNCHRONOUS_ON = build_request("wait for a trigger before each step", 0x0001, read_nothing)
SYNCHRONOUS_OFF = build_request("run without triggers", 0x0002, read_nothing)
TRIGGER = build_request("do one step", 0x0003, read_nothing)
START = Request("start the simulation", 0x1007, pack_ints(0), b"", read_nothing)
STOP = Request("stop the simulation", 0x1007, pack_ints(2), b"", read_nothing)
CLOCK = build_request("read parameter", 0x1021, read_int, 1)
"""A request for the program's version, such as 41000 for 4.10. Each answer contains the simulation's time.

This parameter can be read even while the simulation is stopped.
"""

TIME_STEP = build_request("read parameter", 0x1023, read_float, 1)
"""A request for the simulation's time step, in seconds (``sim_floatparam_simulation_time_step``)."""

_ALL_OBJECTS = 109
"""The number of the group of all objects of a scene, ``sim_appobj_object_type``."""

OBJECT_NAMES = build_request("name the objects of group", 0x200C, read_group, _ALL_OBJECTS, 0)
OBJECT_TYPES = build_request("read the types of the objects of group", 0x200C, read_group, _ALL_OBJECTS, 1)


CREATE_DUMMY = build_request("create a dummy", 0x0009, read_int, data=pack_floats(0.01) + bytes(13))
"""A request that creates a dummy, and reads its handle. The data is its size in m, and no colours."""


def remove_object(handle: int) -> Request[None]:
    """Return a request that removes an object."""
    return build_request("remove object", 0x1028, read_nothing, handle)


def set_object_position(handle: int, x: float, y: float, z: float) -> Request[None]:
    """Return a request that sets the position of an object in the world, in m."""
    return build_request("move object", 0x101B, read_nothing, handle, data=pack_ints(-1) + pack_floats(x, y, z))


def distance(handle: int, other: int) -> Request[float]:
    """Return a request that measures the shortest distance between two objects, in m."""
    return build_request("measure the distance of object", 0x2010, read_float, handle, other)


def object_handle(name: str | bytes) -> Request[int]:
    """Return a request that finds an object by its name and reads its handle.

    From CoppeliaSim 4.3 on, ``name`` may also be the path of the object.
    """
    return build_request("find", 0x3001, read_int, name)


def joint_position(joint: int) -> Request[float]:
    """Return a request that reads the position of a joint, in rad, or in m for a prismatic joint."""
    return build_request("read the position of joint", 0x1001, read_float, joint)


def joint_target_velocity(joint: int, velocity: float) -> Request[None]:
    """Return a request that sets the target velocity of a joint, in rad/s, or in m/s for a prismatic joint."""
    return build_request("drive joint", 0x1008, read_nothing, joint, data=pack_floats(velocity))


def proximity(sensor: int) -> Request[Proximity]:
    """Return a request that reads the detection of a proximity sensor in the last time step."""
    return build_request("read proximity sensor", 0x1009, read_proximity, sensor)


def colour_image(sensor: int) -> Request[Pixels]:
    """Return a request that reads the colour picture of a vision sensor from the last time step."""
    return build_request("read the picture of vision sensor", 0x1004, read_colour, sensor)


def grey_image(sensor: int) -> Request[Pixels]:
    """Return a request that reads the grey picture of a vision sensor, which is the mean of red, green and blue."""
    return build_request("read the grey picture of vision sensor", 0x1003, read_grey, sensor)


def set_colour_image(sensor: int, pixels: bytes) -> Request[None]:
    """Return a request that shows a picture on a vision sensor.

    pixels: RGB in the resolution of the sensor, the lowest row first.
    """
    return build_request("show a picture on vision sensor", 0x1006, read_nothing, sensor, data=pixels)


def set_grey_image(sensor: int, pixels: bytes) -> Request[None]:
    """Return a request that shows a grey picture on a vision sensor.

    pixels: one byte a pixel in the resolution of the sensor, the lowest row first.
    """
    return build_request("show a grey picture on vision sensor", 0x1005, read_nothing, sensor, data=pixels)


def object_position(handle: int) -> Request[list[float]]:
    """Return a request that reads the position of an object in the world: x, y, z in m."""
    return build_request("read the position of object", 0x200E, floats_reader(3), handle, -1)


def picture_width(sensor: int) -> Request[int]:
    """Return a request that reads the width of a vision sensor's picture, in pixels."""
    return build_request("read the width of vision sensor", 0x2008, read_int, sensor, 1002)


def picture_height(sensor: int) -> Request[int]:
    """Return a request that reads the height of a vision sensor's picture, in pixels."""
    return build_request("read the height of vision sensor", 0x2008, read_int, sensor, 1003)


def view_angle(sensor: int) -> Request[float]:
    """Return a request that reads the angle across the longer side of a vision sensor's picture, in rad."""
    return build_request("read the field of view of vision sensor", 0x2007, read_float, sensor, 1004)
