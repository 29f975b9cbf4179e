"""The fields of a protobuf message, for want of a whole library: pictures are the only ones that are read back.

The encoding: https://protobuf.dev/programming-guides/encoding/. The messages: RawImage.proto and CompressedImage.proto
in https://github.com/foxglove/foxglove-sdk/tree/main/schemas/proto/foxglove.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

import cv2
import numpy as np

from robotcore.hal.devices import Image

VARINT, FIXED64, BYTES, FIXED32 = 0, 1, 2, 5
_WIDTH, _HEIGHT, _ENCODING, _DATA = 2, 3, 4, 6
_JPEG = 2
_CHANNELS = {b"bgr8": 3, b"mono8": 1}

_MOST_FIELDS = 64
"""Of a message: a picture has seven."""

_MOST_PIXELS = 2**24
"""The most pixels of a JPEG. A JPEG of few bytes can claim any size; no picture of a camera has more pixels."""

_JPEG_BEGIN = b"\xff\xd8"
_SEGMENT = struct.Struct(">BBH")
_SIZE = struct.Struct(">HH")
_LENGTH_BYTES = 2
_BASELINE = 0xC0
_BEFORE_SIZE = {0xC4, 0xDB, 0xDD, 0xFE, *range(0xE0, 0xF0)}
"""Tables, restart interval, comment, application data: the segments that may come before the size."""


def raw_image(message: bytes | memoryview) -> Image:
    """Return the picture in a RawImage, read-only; ValueError where there is none."""
    told = dict(fields(message))
    width, height = (int.from_bytes(told[field], "little") for field in (_WIDTH, _HEIGHT))
    _require_pixels(width, height)
    channels = _CHANNELS[bytes(told[_ENCODING])]
    shape = (height, width, channels) if channels > 1 else (height, width)
    return np.frombuffer(told[_DATA], np.uint8).reshape(shape)


def compressed_image(message: bytes | memoryview) -> Image:
    """Return the picture in a CompressedImage, read-only; ValueError where there is none."""
    content = dict(fields(message))[_JPEG]
    width, height = _jpeg_size(content)
    _require_pixels(width, height)
    if width * height > _MOST_PIXELS:
        raise ValueError(f"a JPEG claims {width} x {height} pixels")
    try:
        image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise ValueError("it holds no JPEG") from error
    if image is None or image.shape[:2] != (height, width):
        raise ValueError("it holds no JPEG")
    image.flags.writeable = False
    return np.asarray(image, np.uint8)


def _require_pixels(width: int, height: int) -> None:
    if not (width and height):
        raise ValueError(f"a picture has {width} x {height} pixels")


def _jpeg_size(content: memoryview) -> tuple[int, int]:
    """Return the width and height in the header of a baseline JPEG, which is what robotcore writes.

    A decoder must find the same size. So anything between two segments is refused, fill bytes included, which a decoder
    passes over. The segments: ITU-T T.81, annex B.
    """
    if content[:2] != _JPEG_BEGIN:
        raise ValueError("it holds no JPEG")
    at = len(_JPEG_BEGIN)
    while at + _SEGMENT.size <= len(content):
        marker, kind, length = _SEGMENT.unpack_from(content, at)
        if marker == 0xFF and kind == _BASELINE:
            height, width = _SIZE.unpack_from(content, at + _SEGMENT.size + 1)
            return width, height
        if marker != 0xFF or kind not in _BEFORE_SIZE or length < _LENGTH_BYTES:
            break
        at += 2 + length
    raise ValueError("it holds no baseline JPEG")


def fields(message: bytes | memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield the number and the bytes of each field, whatever its type.

    Raises ValueError where the message is cut, or has more fields than a picture.
    """
    left = memoryview(message)
    for _ in range(_MOST_FIELDS):
        if not left:
            return
        tag, left = _varint(left)
        length, left = _length(tag & 7, left)
        if length > len(left):
            raise ValueError("a message ends too early")
        yield tag >> 3, left[:length]
        left = left[length:]
    if left:
        raise ValueError(f"a message has more than {_MOST_FIELDS} fields")


def _length(kind: int, left: memoryview) -> tuple[int, memoryview]:
    """Return how many bytes a field of a kind has, and what they begin."""
    if kind == BYTES:
        return _varint(left)
    if kind == VARINT:
        return len(left) - len(_varint(left)[1]), left
    return {FIXED32: 4, FIXED64: 8}[kind], left


def _varint(left: memoryview) -> tuple[int, memoryview]:
    value = 0
    for at, byte in enumerate(left[:10]):
        value |= (byte & 0x7F) << 7 * at
        if byte < 0x80:
            return value, left[at + 1 :]
    raise ValueError("a message ends within a number")
