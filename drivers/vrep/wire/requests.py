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
    read_colour,
    read_errors,
    read_float,
    read_grey,
    read_int,
    read_nothing,
    read_proximity,
)
from drivers.vrep.wire.errors import ProtocolError, RefusedError

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

PROGRAM_VERSION = 1
"""The number of ``sim_intparam_program_version``. This parameter can be read even while the simulation is stopped."""


def simulator_request(action: str, command: int, decode: Callable[[memoryview], T], data: bytes = b"") -> Request[T]:
    """Return a request to the simulator as a whole.

    action, command, decode, data: see `Request`.
    """
    return Request(action, command, b"", data, decode)


def object_request(
    action: str, command: int, handle: int, decode: Callable[[memoryview], T], data: bytes = b""
) -> Request[T]:
    """Return a request about one object, or about one parameter of the simulator.

    action, command, decode, data: see `Request`. The handle is appended to ``action``.
    handle: the handle of the object, or the number of the parameter.
    """
    return Request(f"{action} {handle}", command, pack_ints(handle), data, decode)


def pair_request(
    action: str, command: int, handle: int, other: int, decode: Callable[[memoryview], T], data: bytes = b""
) -> Request[T]:
    """Return a request about two objects, or about a parameter of an object.

    action, command, decode, data: see `Request`. The handle is appended to ``action``.
    handle: the handle of the first object.
    other: the handle of the second object, or the number of the parameter.
    """
    return Request(f"{action} {handle}", command, pack_ints(handle, other), data, decode)


def named_request(
    action: str, command: int, name: str | bytes, decode: Callable[[memoryview], T], data: bytes = b""
) -> Request[T]:
    """Return a request with a text, such as the name of an object or of a signal.

    action, command, decode, data: see `Request`. The text is appended to ``action``.
    name: the text, which ends at its first zero byte.
    """
    raw = name.encode() if isinstance(name, str) else name
    return Request(f"{action} {name!r}", command, raw.split(b"\0")[0] + b"\0", data, decode)


SYNCHRONOUS_ON = simulator_request("wait for a trigger before each step", 0x0001, read_nothing)
SYNCHRONOUS_OFF = simulator_request("run without triggers", 0x0002, read_nothing)
TRIGGER = simulator_request("do one step", 0x0003, read_nothing)
LAST_ERRORS = simulator_request("read its last errors", 0x0004, read_errors)
START = Request("start the simulation", 0x1007, pack_ints(0), b"", read_nothing)
PAUSE = Request("pause the simulation", 0x1007, pack_ints(1), b"", read_nothing)
STOP = Request("stop the simulation", 0x1007, pack_ints(2), b"", read_nothing)
CLOCK = object_request("read parameter", 0x1021, PROGRAM_VERSION, read_int)
"""A request whose answer is ignored. It is sent because each answer contains the simulation's time."""


def object_handle(name: str | bytes) -> Request[int]:
    """Return a request that finds an object by its name and reads its handle.

    From CoppeliaSim 4.3 on, ``name`` may also be the path of the object.
    """
    return named_request("find", 0x3001, name, read_int)


def joint_position(joint: int) -> Request[float]:
    """Return a request that reads the position of a joint, in rad, or in m for a prismatic joint."""
    return object_request("read the position of joint", 0x1001, joint, read_float)


def joint_target_velocity(joint: int, velocity: float) -> Request[None]:
    """Return a request that sets the target velocity of a joint, in rad/s, or in m/s for a prismatic joint."""
    return object_request("drive joint", 0x1008, joint, read_nothing, pack_floats(velocity))


def proximity(sensor: int) -> Request[Proximity]:
    """Return a request that reads the detection of a proximity sensor in the last time step."""
    return object_request("read proximity sensor", 0x1009, sensor, read_proximity)


def colour_image(sensor: int) -> Request[Pixels]:
    """Return a request that reads the colour image of a vision sensor from the last time step."""
    return object_request("read the image of vision sensor", 0x1004, sensor, read_colour)


def grey_image(sensor: int) -> Request[Pixels]:
    """Return a request that reads the grey image of a vision sensor, which is the mean of red, green and blue."""
    return object_request("read the grey image of vision sensor", 0x1003, sensor, read_grey)


def set_colour_image(sensor: int, pixels: bytes) -> Request[None]:
    """Return a request that shows an image on a vision sensor.

    pixels: RGB in the resolution of the sensor, the lowest row first.
    """
    return object_request("show an image on vision sensor", 0x1006, sensor, read_nothing, pixels)


def set_grey_image(sensor: int, pixels: bytes) -> Request[None]:
    """Return a request that shows a grey image on a vision sensor.

    pixels: one byte a pixel in the resolution of the sensor, the lowest row first.
    """
    return object_request("show a grey image on vision sensor", 0x1005, sensor, read_nothing, pixels)


def object_position(handle: int, relative_to: int = -1) -> Request[list[float]]:
    """Return a request that reads the position of an object: x, y, z in m.

    relative_to: the handle of the object whose frame is used; -1 means the world.
    """
    return pair_request("read the position of object", 0x200E, handle, relative_to, floats_reader(3))


def float_parameter(number: int) -> Request[float]:
    """Return a request that reads a parameter of the simulator.

    number: the value of ``sim_floatparam_…``.
    """
    return object_request("read parameter", 0x1023, number, read_float)
