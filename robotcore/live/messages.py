"""The messages between a run and the process of its page: JSON, and raw pictures after it.

Each message is a head of eight bytes, a JSON text, and the bytes of a picture. The head has the lengths of both, as
two unsigned 32-bit integers in network order.
"""

from __future__ import annotations

import json
import math
import struct
from typing import Any, NamedTuple

HEAD = struct.Struct("!II")

MAX_JSON_BYTES = 4 * 1024 * 1024
MAX_PICTURE_BYTES = 32 * 1024 * 1024


class Message(NamedTuple):
    """A message of a run to the process of its page."""

    content: dict[str, Any]
    """The content, with the key ``type``."""
    picture: memoryview | bytes = b""
    """The pixels of a picture, BGR or grey, row after row."""

    def pack(self) -> bytes:
        """Return the head and the JSON text. The picture follows them."""
        text = encode(self.content)
        return HEAD.pack(len(text), len(self.picture)) + text


def encode(content: dict[str, Any]) -> bytes:
    """Return a message as JSON. Its numbers must be finite: see `to_json`."""
    return json.dumps(content, separators=(",", ":"), allow_nan=False).encode()


def to_json(value: Any) -> Any:
    """Return a value with None in place of each number that JSON does not have: NaN and infinity.

    >>> to_json({"distance": math.inf, "values": (0.123456789, True)})
    {'distance': None, 'values': [0.12346, True]}
    """
    if isinstance(value, dict):
        return {str(key): to_json(each) for key, each in value.items()}
    if isinstance(value, (tuple, list)):
        return [to_json(each) for each in value]
    if isinstance(value, (bool, int, str)) or value is None:
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        return str(value)
    return round(number, 5) if math.isfinite(number) else None
