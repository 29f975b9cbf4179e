"""Convert events to JSON and back, and decode the protobuf messages of pictures and log lines.

A number that was written and read has the same bits. In JSON, ``inf`` and ``nan`` are strings. Fields with None or an
empty tuple are left out, unless the field has no default.
Protobuf: https://protobuf.dev/programming-guides/encoding/. RawImage.proto, CompressedImage.proto and Log.proto:
https://github.com/foxglove/foxglove-sdk/tree/main/schemas/proto/foxglove.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from functools import cache
from numbers import Integral, Real
from types import NoneType
from typing import Annotated, Any, TypeVar, cast, get_args, get_origin, get_type_hints

import cv2
import numpy as np
from pydantic import BaseModel, TypeAdapter

from robotcore.optics import Image

T = TypeVar("T")


def to_json(event: Any) -> bytes:
    """Return an event, such as a tick or the metadata, as JSON."""
    return json.dumps(to_plain(event), allow_nan=False, separators=(",", ":")).encode()


def from_json(kind: type[T], content: bytes) -> T:
    """Return the event of the class ``kind`` that `to_json` wrote. Raises ValueError for any other text."""
    adapter: TypeAdapter[T] = _adapter(cast("Any", kind))
    return adapter.validate_json(content)


def to_plain(value: Any) -> Any:
    """Return a value as numbers, strings, lists and dicts, which JSON supports.

    A dataclass or a named tuple becomes a dict of its fields. A member of an enumeration becomes its value. An array
    of NumPy becomes a list. A value of any other class becomes ``str(value)``.
    """
    kind: Any = type(value)
    if kind in _SCALARS:
        return _to_scalar(value)
    names, required = _list_encoded(kind)
    if names:
        named = ((name, getattr(value, name)) for name in names)
        return {
            name: to_plain(each)
            for name, each in named
            if (each is not None and (not isinstance(each, tuple) or each)) or name in required
        }
    if isinstance(value, Enum):
        return to_plain(value.value)
    if isinstance(value, BaseModel):
        value = value.model_dump()
    if isinstance(value, Mapping):
        return {_to_text(key): to_plain(each) for key, each in value.items()}
    if isinstance(value, (tuple, list, set, frozenset)):
        return [to_plain(each) for each in value]
    return to_plain(value.tolist()) if isinstance(value, (np.ndarray, np.generic)) else _to_scalar(value)


_SCALARS = frozenset((float, int, str, bool, type(None)))
"""The most frequent types. They are recognised first, because this is faster."""


def _to_scalar(value: Any) -> Any:
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else repr(float(value))
    if isinstance(value, str):
        return _to_text(value)
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, (int, Integral)):
        return int(value)
    return _to_scalar(float(value)) if isinstance(value, Real) else _to_text(value)


def _to_text(value: Any) -> str:
    text = value if isinstance(value, str) else str(value)
    return str.encode(text, errors="backslashreplace").decode()


@cache
def list_fields(kind: Any) -> tuple[str, ...]:
    """Return the names of the fields of a dataclass or a named tuple; none for another class."""
    return tuple(field.name for field in fields(kind)) if is_dataclass(kind) else getattr(kind, "_fields", ())


@cache
def _list_encoded(kind: Any) -> tuple[tuple[str, ...], frozenset[str]]:
    """Return the names of the fields of a class, and of those without a default, which a reader needs."""
    names = list_fields(kind)
    if not is_dataclass(kind):
        return names, frozenset(names) - getattr(kind, "_field_defaults", {}).keys()
    return names, frozenset(each.name for each in fields(kind) if each.default is each.default_factory is MISSING)


Schema = dict[str, Any]
"""A JSON schema."""

_TYPES = {bool: "boolean", float: "number", int: "integer", str: "string"}


def build_schema(kind: Any) -> Schema:
    """Return the schema of a type. Fields of an optional type have the schema of the type without None."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return build_schema(arguments[0])
    if NoneType in arguments:
        return build_schema(next(each for each in arguments if each is not NoneType))
    if origin is tuple:
        return {"type": "array", "items": build_schema(arguments[0])}
    if kind in _TYPES:
        return {"type": _TYPES[kind]}
    names = list_fields(kind)
    hints = get_type_hints(kind, include_extras=True) if names else {}
    return {"type": "object", "properties": {name: build_schema(hints[name]) for name in names}}


def name_schema(title: str, kind: Any = None, **properties: Any) -> Schema:
    """Return the schema of a class, or of an object with ``properties``, under a title."""
    named = {name: build_schema(each) for name, each in properties.items()}
    schema = {"type": "object", "properties": named} if kind is None else build_schema(kind)
    return {"title": f"robotcore.{title}", **schema}


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


VARINT, FIXED64, BYTES, FIXED32 = 0, 1, 2, 5
_WIDTH, _HEIGHT, _ENCODING, _DATA = 2, 3, 4, 6
_JPEG = 2
_TEXT, _SOURCE = 3, 4
_CHANNELS = {b"bgr8": 3, b"mono8": 1}

_MAX_FIELDS = 64
"""The maximum number of fields of a protobuf message. A picture's message has seven."""

_MAX_PIXELS = 2**24
"""The maximum number of pixels of a JPEG. The header of a small JPEG can state any size."""

_JPEG_BEGIN = b"\xff\xd8"
_SEGMENT = struct.Struct(">BBH")
_SIZE = struct.Struct(">HH")
_LENGTH_BYTES = 2
_BASELINE = 0xC0
_BEFORE_SIZE = {0xC4, 0xDB, 0xDD, 0xFE, *range(0xE0, 0xF0)}
"""The JPEG segments that may precede the size of the picture: tables, restart interval, comment, application data."""


def decode_raw_image(message: bytes | memoryview) -> Image:
    """Return the read-only picture of a RawImage message. Raises ValueError if the message has none."""
    values = dict(read_fields(message))
    width, height = (int.from_bytes(values[field], "little") for field in (_WIDTH, _HEIGHT))
    _require_pixels(width, height)
    channels = _CHANNELS[bytes(values[_ENCODING])]
    shape = (height, width, channels) if channels > 1 else (height, width)
    return np.frombuffer(values[_DATA], np.uint8).reshape(shape)


def decode_compressed_image(message: bytes | memoryview) -> Image:
    """Return the read-only picture of a CompressedImage message. Raises ValueError if the message has none."""
    content = dict(read_fields(message))[_JPEG]
    width, height = _read_jpeg_size(content)
    _require_pixels(width, height)
    if width * height > _MAX_PIXELS:
        raise ValueError(f"the header of a JPEG states {width} x {height} pixels, which is too large")
    try:
        image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise ValueError("a compressed picture is not a JPEG") from error
    if image is None or image.shape[:2] != (height, width):
        raise ValueError("a compressed picture is not a JPEG")
    image.flags.writeable = False
    return np.asarray(image, np.uint8)


def decode_log_line(message: bytes | memoryview) -> tuple[str, str]:
    """Return the source and the text of a Log message. Raises ValueError if they are not UTF-8."""
    values = dict(read_fields(message))
    source, text = (bytes(values.get(field, b"")).decode() for field in (_SOURCE, _TEXT))
    return source, text


def _require_pixels(width: int, height: int) -> None:
    if not (width and height):
        raise ValueError(f"a picture has no pixels: {width} x {height}")


def _read_jpeg_size(content: memoryview) -> tuple[int, int]:
    """Return the width and the height in the header of a baseline JPEG, the type that robotcore writes.

    Only a header without fill bytes between its segments is accepted, so that a decoder finds the same size.
    The format is ITU-T T.81, annex B.
    """
    if content[:2] != _JPEG_BEGIN:
        raise ValueError("a compressed picture is not a JPEG")
    at = len(_JPEG_BEGIN)
    while at + _SEGMENT.size <= len(content):
        marker, kind, length = _SEGMENT.unpack_from(content, at)
        if marker == 0xFF and kind == _BASELINE:
            height, width = _SIZE.unpack_from(content, at + _SEGMENT.size + 1)
            return width, height
        if marker != 0xFF or kind not in _BEFORE_SIZE or length < _LENGTH_BYTES:
            break
        at += 2 + length
    raise ValueError("a compressed picture is not a baseline JPEG")


def read_fields(message: bytes | memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield the number and the bytes of each field of a protobuf message.

    Raises ValueError if the message is incomplete or has too many fields.
    """
    left = memoryview(message)
    for _ in range(_MAX_FIELDS):
        if not left:
            return
        tag, left = _read_varint(left)
        length, left = _read_length(tag & 7, left)
        if length > len(left):
            raise ValueError("a message ends before the end of a field")
        yield tag >> 3, left[:length]
        left = left[length:]
    if left:
        raise ValueError(f"a message has more than {_MAX_FIELDS} fields")


def _read_length(wire_type: int, left: memoryview) -> tuple[int, memoryview]:
    """Return the length of a field in bytes, and the rest of the message, which begins with the field's bytes."""
    if wire_type == BYTES:
        return _read_varint(left)
    if wire_type == VARINT:
        return len(left) - len(_read_varint(left)[1]), left
    return {FIXED32: 4, FIXED64: 8}[wire_type], left


def _read_varint(left: memoryview) -> tuple[int, memoryview]:
    value = 0
    for at, byte in enumerate(left[:10]):
        value |= (byte & 0x7F) << 7 * at
        if byte < 0x80:
            return value, left[at + 1 :]
    raise ValueError("a message ends within a number")
