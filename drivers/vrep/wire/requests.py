"""One request of the legacy remote API: a command, what it is about, and how its answer is read."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from drivers.vrep.wire.codec import (
    Piece,
    Pixels,
    Proximity,
    Vector,
    encode_command,
    floats,
    pack_floats,
    pack_ints,
    read_colour,
    read_errors,
    read_float,
    read_grey,
    read_int,
    read_ints,
    read_nothing,
    read_proximity,
)
from drivers.vrep.wire.errors import GarbledReplyError, RefusedError

T_co = TypeVar("T_co", covariant=True)

ONESHOT = 0x000000
BLOCKING = 0x010000
STREAMING = 0x020000
ONESHOT_SPLIT = 0x030000
STREAMING_SPLIT = 0x040000
DISCONTINUE = 0x050000
BUFFER = 0x060000
REMOVE = 0x070000

Identity = tuple[int, bytes]
"""A command's number and its key: a later command of the same identity takes the place of an earlier one."""


@dataclass(frozen=True)
class Request(Generic[T_co]):
    """Ask ``command`` about ``key``, the handles or names it concerns, with ``data``; ``decode`` reads the answer.

    ``words`` are for error messages.
    """

    words: str
    command: int
    key: bytes
    data: bytes
    decode: Callable[[memoryview], T_co] = field(compare=False)

    @property
    def identity(self) -> Identity:
        return self.command, self.key

    def encoded(self, mode: int = ONESHOT, delay: int = 0) -> bytes:
        """Return it as it stands in a message."""
        return encode_command(self.command, mode, delay, self.key, self.data)

    def read(self, answer: Piece) -> T_co:
        """Return the value in an answer; RefusedError if the server could not do it."""
        if answer.is_failed:
            raise RefusedError(f"the simulator refused to {self.words}")
        try:
            return self.decode(answer.data)
        except (struct.error, ValueError) as error:
            raise GarbledReplyError(f"{len(answer.data)} bytes answer the request to {self.words}") from error


T = TypeVar("T")

PROGRAM_VERSION = 1
"""The number of the integer parameter that every simulator can tell at any time."""


def of_nothing(words: str, command: int, decode: Callable[[memoryview], T], data: bytes = b"") -> Request[T]:
    """Return a request about the whole simulator."""
    return Request(words, command, b"", data, decode)


def of_handle(
    words: str, command: int, handle: int, decode: Callable[[memoryview], T], data: bytes = b""
) -> Request[T]:
    """Return a request about one object."""
    return Request(f"{words} {handle}", command, pack_ints(handle), data, decode)


def of_handles(
    words: str, command: int, handle: int, other: int, decode: Callable[[memoryview], T], data: bytes = b""
) -> Request[T]:
    """Return a request about two objects, or one and something of it."""
    return Request(f"{words} {handle}", command, pack_ints(handle, other), data, decode)


def of_name(
    words: str, command: int, name: str | bytes, decode: Callable[[memoryview], T], data: bytes = b""
) -> Request[T]:
    """Return a request about what has a name, which ends where it has a zero as C's do."""
    raw = name.encode() if isinstance(name, str) else name
    return Request(f"{words} {name!r}", command, raw.split(b"\0")[0] + b"\0", data, decode)


SYNCHRONOUS_ON = of_nothing("wait for a trigger before each step", 0x0001, read_nothing)
SYNCHRONOUS_OFF = of_nothing("go on without triggers", 0x0002, read_nothing)
TRIGGER = of_nothing("take one step", 0x0003, read_nothing)
LAST_ERRORS = of_nothing("tell what went wrong", 0x0004, read_errors)
START = of_handle("start the simulation", 0x1007, 0, read_nothing)
PAUSE = of_handle("pause the simulation", 0x1007, 1, read_nothing)
STOP = of_handle("stop the simulation", 0x1007, 2, read_nothing)
CLOCK = of_handle("tell parameter", 0x1021, PROGRAM_VERSION, read_int)
"""Asked for the time that each answer carries."""


def object_handle(name: str | bytes) -> Request[int]:
    """The handle of the object of that name, or path from CoppeliaSim 4.3 on."""
    return of_name("find", 0x3001, name, read_int)


def joint_position(joint: int) -> Request[float]:
    """In rad, or in m where it slides."""
    return of_handle("tell the position of joint", 0x1001, joint, read_float)


def joint_target_velocity(joint: int, velocity: float) -> Request[None]:
    """In rad/s, or in m/s where it slides."""
    return of_handle("drive joint", 0x1008, joint, read_nothing, pack_floats(velocity))


def proximity(sensor: int) -> Request[Proximity]:
    """What a proximity sensor has seen in the last step."""
    return of_handle("read proximity sensor", 0x1009, sensor, read_proximity)


def colour_image(sensor: int) -> Request[Pixels]:
    """What a vision sensor has seen in the last step."""
    return of_handle("tell the image of vision sensor", 0x1004, sensor, read_colour)


def grey_image(sensor: int) -> Request[Pixels]:
    """The same in grey: the mean of red, green and blue."""
    return of_handle("tell the grey image of vision sensor", 0x1003, sensor, read_grey)


def set_colour_image(sensor: int, pixels: bytes) -> Request[None]:
    """Three bytes a pixel, RGB, the lowest row first; as many as the sensor has, or it is refused."""
    return of_handle("show an image on vision sensor", 0x1006, sensor, read_nothing, pixels)


def set_grey_image(sensor: int, pixels: bytes) -> Request[None]:
    """A byte a pixel, the lowest row first; as many as the sensor has, or it is refused."""
    return of_handle("show a grey image on vision sensor", 0x1005, sensor, read_nothing, pixels)


def object_position(handle: int, relative_to: int = -1) -> Request[Vector]:
    """x, y, z in m."""
    return of_handles("tell the position of object", 0x200E, handle, relative_to, floats(3))


def object_orientation(handle: int, relative_to: int = -1) -> Request[Vector]:
    """Euler angles alpha, beta, gamma about x, y', z'' in rad."""
    return of_handles("tell the orientation of object", 0x200D, handle, relative_to, floats(3))


def object_velocity(handle: int) -> Request[Vector]:
    """Linear in m/s, then angular in rad/s, in the world's frame."""
    return of_handle("tell the velocity of object", 0x1036, handle, floats(6))


def object_parent(handle: int) -> Request[int]:
    """-1 where it has none."""
    return of_handle("tell the parent of object", 0x1012, handle, read_int)


def objects(kind: int) -> Request[list[int]]:
    """The handles of all objects of a kind (`sim_object_…_type`)."""
    return of_handle("list objects of type", 0x102A, kind, read_ints)


def float_parameter(number: int) -> Request[float]:
    """One of `sim_floatparam_…`."""
    return of_handle("tell parameter", 0x1023, number, read_float)


def set_float_parameter(number: int, value: float) -> Request[None]:
    """One of `sim_floatparam_…`."""
    return of_handle("set parameter", 0x1024, number, read_nothing, pack_floats(value))


def int_parameter(number: int) -> Request[int]:
    """One of `sim_intparam_…`."""
    return of_handle("tell parameter", 0x1021, number, read_int)


def statusbar_message(text: str | bytes) -> Request[None]:
    """A line for the one who sits at the simulator."""
    return of_name("show", 0x3008, text, read_nothing)
