"""What answers of the legacy remote API say: how their bytes are read, and how ours are written.

The layouts are those that the functions of the same names in the maker's extApi.c read. A reader raises struct.error or
ValueError where the bytes do not fit.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[np.uint8]
Vector = tuple[float, ...]


@dataclass(frozen=True)
class Proximity:
    """What a proximity sensor says. Unless ``is_detected``, all the rest is rubbish.

    ``point`` and ``normal`` are in the sensor's frame, in metres; the distance is the norm of the point.
    """

    is_detected: bool
    point: Vector
    handle: int
    normal: Vector


def read_int(data: memoryview) -> int:
    """Return a number of 32 bits."""
    return int(struct.unpack_from("<i", data)[0])


def read_float(data: memoryview) -> float:
    """Return a number of single precision."""
    return float(struct.unpack_from("<f", data)[0])


def read_nothing(data: memoryview) -> None:
    """Whatever data a server sends along with what has no value."""


def floats(count: int, offset: int = 0) -> Callable[[memoryview], Vector]:
    """Return what reads so many numbers, after so many bytes."""
    return lambda data: struct.unpack_from(f"<{count}f", data, offset)


def read_proximity(data: memoryview) -> Proximity:
    """Return what a proximity sensor says."""
    detect, *numbers = struct.unpack_from("<B3fi3f", data)
    return Proximity(detect != 0, tuple(numbers[:3]), numbers[3], tuple(numbers[4:]))


def read_colour(data: memoryview) -> Pixels:
    """Return the image: (height, width, 3), RGB, row 0 at the bottom; read-only."""
    return np.frombuffer(data, np.uint8, offset=8).reshape(*_rows_and_columns(data), 3)


def read_grey(data: memoryview) -> Pixels:
    """Return the image: (height, width), row 0 at the bottom; read-only."""
    return np.frombuffer(data, np.uint8, offset=8).reshape(_rows_and_columns(data))


def read_depth(data: memoryview) -> npt.NDArray[np.float32]:
    """Return the depth: (height, width), 0 at the near and 1 at the far clipping plane, row 0 at the bottom."""
    return np.frombuffer(data, np.dtype("<f4"), offset=8).reshape(_rows_and_columns(data))


def _rows_and_columns(data: memoryview) -> tuple[int, int]:
    width, height = struct.unpack_from("<2i", data)
    if width < 1 or height < 1:
        raise ValueError(f"an image of {width} × {height}")
    return height, width


def read_errors(data: memoryview) -> list[str]:
    """Return messages, oldest first."""
    count = read_int(data)
    return [words.decode("utf-8", "replace") for words in bytes(data[4:]).split(b"\0")[:count]]


def read_ints(data: memoryview) -> list[int]:
    """Return the numbers that follow their count."""
    return list(struct.unpack_from(f"<{max(read_int(data), 0)}i", data, 4))


def pack_floats(*values: float) -> bytes:
    """Return numbers as C's floats, whatever type they are of."""
    return struct.pack(f"<{len(values)}f", *values)


def pack_ints(*values: int) -> bytes:
    """Return numbers as C's ints, whatever type they are of."""
    return struct.pack(f"<{len(values)}i", *values)


def read_text(data: memoryview) -> str:
    """Return a text, which ends where it has a zero."""
    return bytes(data).split(b"\0")[0].decode("utf-8", "replace")
