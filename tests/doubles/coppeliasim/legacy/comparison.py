"""Compare a reply of the double with one of the real server.

Equal must be: the order of commands, each with its number, mode, identity, size and error bit; the header's state,
scene and message number; handles, error texts, parameters and signals.

Poses, joint positions, pixels and times have tolerances: the real robot slips, and another machine renders its light.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Iterator
from itertools import zip_longest
from types import TracebackType

import numpy as np

from tests.doubles.coppeliasim.legacy.codec import (
    Code,
    Command,
    Header,
    Mode,
    encode_packets,
    pack,
    read_message,
    unpack,
)

JOINT_RAD = 0.01
POSITION_M = 0.006
ORIENTATION_RAD = 0.005
PIXELS_MEAN = 10
"""The tolerance of the mean difference between two pictures, in grey levels."""
TIME_MS = 1
LAST_STEPS_MS = 100
"""The tolerance of simulated times in ms for the last steps before a stop."""

RESOLUTION = struct.calcsize("<2i")

Message = tuple[Header, list[Command]]


def find_differences(recorded: Message, reply: Message, time_ms: int = TIME_MS) -> list[str]:
    """Return the differences between a recorded message and a reply, one in each line."""
    return [*_compare_headers(recorded[0], reply[0]), *_compare_commands(recorded[1], reply[1], time_ms)]


def _compare_headers(recorded: Header, reply: Header) -> Iterator[str]:
    for name in ("scene", "state"):
        if getattr(recorded, name) != getattr(reply, name):
            yield f"header: {name} {getattr(reply, name)}, recorded {getattr(recorded, name)}"


def _compare_commands(recorded: list[Command], reply: list[Command], time_ms: int) -> Iterator[str]:
    for one, other in zip_longest(recorded, reply):
        if one is None or other is None:
            yield f"commands: {reply}, recorded {recorded}"
            return
        yield from _compare_command(one, other, time_ms)


def _compare_command(recorded: Command, reply: Command, time_ms: int) -> Iterator[str]:
    for name in ("code", "mode", "identity", "delay_ms", "status"):
        if getattr(recorded, name) != getattr(reply, name):
            yield f"command {recorded.code}: {name} {getattr(reply, name)}, recorded {getattr(recorded, name)}"
    if abs(recorded.sim_ms - reply.sim_ms) > time_ms:
        yield f"command {recorded.code}: at {reply.sim_ms} ms, recorded {recorded.sim_ms} ms"
    if len(recorded.data) != len(reply.data):
        yield f"command {recorded.code}: {len(reply.data)} bytes of data, recorded {len(recorded.data)}"
    elif not CLOSE.get(recorded.code, _equal)(recorded.data, reply.data):
        yield f"command {recorded.code}: {reply.data.hex()}, recorded {recorded.data.hex()}"


def _equal(one: bytes, other: bytes) -> bool:
    return one == other


def _within(tolerance: float) -> Callable[[bytes, bytes], bool]:
    def close(one: bytes, other: bytes) -> bool:
        return bool(np.allclose(np.frombuffer(one, "<f4"), np.frombuffer(other, "<f4"), rtol=0, atol=tolerance))

    return close


def _compare_pictures(one: bytes, other: bytes) -> bool:
    if not one:
        return True
    pixels = [np.frombuffer(data[RESOLUTION:], np.uint8).astype(int) for data in (one, other)]
    return one[:RESOLUTION] == other[:RESOLUTION] and bool(np.abs(pixels[0] - pixels[1]).mean() <= PIXELS_MEAN)


def _compare_detections(one: bytes, other: bytes) -> bool:
    """Compare detections. If nothing is detected, all bytes but the first are arbitrary."""
    return one[0] == other[0] == 0


CLOSE: dict[int, Callable[[bytes, bytes], bool]] = {
    Code.GET_JOINT_POSITION: _within(JOINT_RAD),
    Code.GET_OBJECT_POSITION: _within(POSITION_M),
    Code.GET_OBJECT_ORIENTATION: _within(ORIENTATION_RAD),
    Code.GET_VISION_SENSOR_IMAGE_BW: _compare_pictures,
    Code.GET_VISION_SENSOR_IMAGE_RGB: _compare_pictures,
    Code.READ_PROXIMITY_SENSOR: _compare_detections,
}


PATIENCE_S = 5.0


class RawClient:
    """A client of a legacy server on this computer, as a context manager."""

    def __init__(self, port: int, patience_s: float = PATIENCE_S) -> None:
        self.line = socket.create_connection(("127.0.0.1", port), patience_s)
        self.line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._number = 0

    def __enter__(self) -> RawClient:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.line.close()

    def exchange(self, *commands: Command) -> Message:
        """Send a message, and return the reply, which contains the answers to the previous message."""
        self.send(*commands)
        return unpack(read_message(self._receive))

    def send(self, *commands: Command) -> None:
        """Send a message without waiting for the reply."""
        self.line.sendall(encode_packets(pack(Header(self._number, 0), commands)))
        self._number += 1

    def execute(self, code: Code, identity: bytes = b"", data: bytes = b"") -> Command:
        """Send a command, and return its answer."""
        self.exchange(Command(code, Mode.BLOCKING, identity, data))
        _, (reply,) = self.exchange()
        return reply

    def _receive(self, size: int) -> bytes:
        return self.line.recv(size, socket.MSG_WAITALL)


def ints(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}i", *numbers)


def floats(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}f", *numbers)


def name(text: str) -> bytes:
    return text.encode() + b"\0"
