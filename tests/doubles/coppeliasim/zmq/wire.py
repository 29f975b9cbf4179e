"""CBOR as the server writes it: every float in the shortest form that holds it (RFC 8949, preferred serialization).

Reading is the package's; writing is here, because the package writes every float in eight bytes, and replies are
compared to recorded ones byte by byte.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from typing import Any

NAN = bytes.fromhex("f97e00")
SIMPLE = {False: b"\xf4", True: b"\xf5", None: b"\xf6"}


def loads(data: bytes) -> Any:
    """Return what a message holds; ValueError where it is none."""
    import cbor

    try:
        return cbor.loads(data)
    except Exception as error:
        raise ValueError(f"no CBOR: {error}") from error


def dumps(value: Any) -> bytes:
    """Return a message that holds numbers, text, bytes, lists, dicts, truth values and None."""
    return b"".join(_encoded(value))


def _encoded(value: Any) -> Iterator[bytes]:
    if value is None or isinstance(value, bool):
        yield SIMPLE[value]
    elif isinstance(value, int):
        yield _head(0, int(value)) if value >= 0 else _head(1, -1 - int(value))
    elif isinstance(value, float):
        yield _float(value)
    elif isinstance(value, bytes):
        yield _head(2, len(value))
        yield value
    elif isinstance(value, str):
        text = value.encode()
        yield _head(3, len(text))
        yield text
    else:
        yield from _container(value)


def _container(value: Any) -> Iterator[bytes]:
    if isinstance(value, Mapping):
        yield _head(5, len(value))
        for key, each in value.items():
            yield from _encoded(key)
            yield from _encoded(each)
    elif isinstance(value, (list, tuple)):
        yield _head(4, len(value))
        for each in value:
            yield from _encoded(each)
    else:
        raise TypeError(f"{type(value).__name__} has no place in a message")


def _head(major: int, argument: int) -> bytes:
    """Return a data item's head: its major type, and its length or value."""
    if argument < 24:
        return bytes(((major << 5) | argument,))
    size = next(size for size in range(4) if argument < 1 << (8 << size))
    return bytes(((major << 5) | 24 + size,)) + argument.to_bytes(1 << size, "big")


def _float(value: float) -> bytes:
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
