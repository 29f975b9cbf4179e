"""Where two replies differ, in words; nothing where the double's is as good as the real server's."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tests.doubles.coppeliasim.replaying.tolerances import AT_THE_WALL_M, EXACT, Tolerance


def differences(recorded: Any, reply: Any, tolerance: Tolerance = EXACT, where: str = "reply") -> Iterator[str]:
    """Yield what is different, a line each."""
    if type(recorded) is not type(reply):
        yield f"{where}: {_short(reply)}, recorded {_short(recorded)}"
    elif isinstance(recorded, dict):
        yield from _in_maps(recorded, reply, tolerance, where)
    elif isinstance(recorded, list):
        yield from _in_lists(recorded, reply, tolerance, where)
    elif isinstance(recorded, bytes):
        yield from _in_bytes(recorded, reply, tolerance, where)
    elif isinstance(recorded, float):
        if not _is_near(recorded, reply, tolerance.number):
            yield f"{where}: {reply}, recorded {recorded}"
    elif recorded != reply:
        yield f"{where}: {_short(reply)}, recorded {_short(recorded)}"


def _in_maps(recorded: Any, reply: Any, tolerance: Tolerance, where: str) -> Iterator[str]:
    """A table of Lua's has no order of its keys; the server's own replies have."""
    in_order = where == "reply"
    if (list(recorded) != list(reply)) if in_order else (recorded.keys() != reply.keys()):
        yield f"{where}: keys {list(reply)}, recorded {list(recorded)}"
        return
    for key, each in recorded.items():
        yield from differences(each, reply[key], tolerance, f"{where}.{key}")


def _in_lists(recorded: Any, reply: Any, tolerance: Tolerance, where: str) -> Iterator[str]:
    if len(recorded) != len(reply):
        yield f"{where}: {len(reply)} values, recorded {len(recorded)}"
        return
    for i, (one, other) in enumerate(zip(recorded, reply, strict=True)):
        yield from differences(one, other, tolerance, f"{where}[{i}]")


def _in_bytes(recorded: bytes, reply: bytes, tolerance: Tolerance, where: str) -> Iterator[str]:
    if len(recorded) != len(reply):
        yield f"{where}: {len(reply)} bytes, recorded {len(recorded)}"
    elif tolerance.depth and len(recorded) == DEPTHS_BYTES:
        yield from _in_depths(recorded, reply, tolerance.depth, where)
    elif (off := _mean_off(recorded, reply)) > tolerance.pixels:
        yield f"{where}: {off:.1f} levels off on average"


DEPTHS_BYTES = 36
"""The recorded depths are nine floats; pictures are longer."""


def _in_depths(recorded: bytes, reply: bytes, tolerance: float, where: str) -> Iterator[str]:
    one, other = (np.frombuffer(each, "<f4") for each in (recorded, reply))
    at_the_wall = min(one.min(), other.min()) < AT_THE_WALL_M
    if not at_the_wall and (off := float(np.abs(one - other).max())) > tolerance:
        yield f"{where}: {off:.3f} m off"


def _mean_off(recorded: bytes, reply: bytes) -> float:
    one, other = (np.frombuffer(each, np.uint8).astype(float) for each in (recorded, reply))
    return float(np.abs(one - other).mean()) if len(one) else 0.0


def _is_near(recorded: float, reply: float, tolerance: float) -> bool:
    if math.isnan(recorded) or math.isnan(reply):
        return math.isnan(recorded) and math.isnan(reply)
    return abs(recorded - reply) <= tolerance


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) < 90 else f"{text[:90]}…"
