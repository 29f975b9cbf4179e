"""CBOR as the server encodes it: each float in the shortest exact form (RFC 8949, preferred serialization).

A package decodes messages. It would encode each float in eight bytes, so this module encodes them. Replies are compared
with recorded ones byte by byte.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from typing import Any

NAN = bytes.fromhex("f97e00")
SIMPLE = {False: b"\xf4", True: b"\xf5", None: b"\xf6"}


def loads(data: bytes) -> Any:
    """Decode a message. Raises ValueError if it is invalid."""
    import cbor

    try:
        return cbor.loads(data)
    except Exception as error:
        raise ValueError(f"no CBOR: {error}") from error


def dumps(value: Any) -> bytes:
    """Encode numbers, text, bytes, lists, dicts, booleans and None."""
    return b"".join(_encode(value))


def _encode(value: Any) -> Iterator[bytes]:
    if value is None or isinstance(value, bool):
        yield SIMPLE[value]
    elif isinstance(value, int):
        yield _encode_head(0, int(value)) if value >= 0 else _encode_head(1, -1 - int(value))
    elif isinstance(value, float):
        yield _encode_float(value)
    elif isinstance(value, bytes):
        yield _encode_head(2, len(value))
        yield value
    elif isinstance(value, str):
        text = value.encode()
        yield _encode_head(3, len(text))
        yield text
    else:
        yield from _encode_container(value)


def _encode_container(value: Any) -> Iterator[bytes]:
    if isinstance(value, Mapping):
        yield _encode_head(5, len(value))
        for key, each in value.items():
            yield from _encode(key)
            yield from _encode(each)
    elif isinstance(value, (list, tuple)):
        yield _encode_head(4, len(value))
        for each in value:
            yield from _encode(each)
    else:
        raise TypeError(f"{type(value).__name__} has no place in a message")


def _encode_head(major: int, argument: int) -> bytes:
    """Return the head of a data item: its major type, and its length or value."""
    if argument < 24:
        return bytes(((major << 5) | argument,))
    size = next(size for size in range(4) if argument < 1 << (8 << size))
    return bytes(((major << 5) | 24 + size,)) + argument.to_bytes(1 << size, "big")


def _encode_float(value: float) -> bytes:
    if math.isnan(value):
        return NAN
    for lead, form in ((b"\xf9", ">e"), (b"\xfa", ">f")):
        try:
            packed = struct.pack(form, value)
        except OverflowError:
            continue
        if struct.unpack(form, packed)[0] == value:
            return lead + packed
    return b"\xfb" + struct.pack(">d", value)
