"""Where two replies differ, in words; nothing where the double's is as good as the real server's."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tests.doubles.coppeliasim.replaying.tolerances import AT_THE_WALL_M, EXACT, Tolerance


def differences(recorded: Any, told: Any, tolerance: Tolerance = EXACT, where: str = "reply") -> Iterator[str]:
    """Yield what is different, a line each."""
    if type(recorded) is not type(told):
        yield f"{where}: {_short(told)}, recorded {_short(recorded)}"
    elif isinstance(recorded, dict):
        yield from _in_maps(recorded, told, tolerance, where)
    elif isinstance(recorded, list):
        yield from _in_lists(recorded, told, tolerance, where)
    elif isinstance(recorded, bytes):
        yield from _in_bytes(recorded, told, tolerance, where)
    elif isinstance(recorded, float):
        if not _is_near(recorded, told, tolerance.number):
            yield f"{where}: {told}, recorded {recorded}"
    elif recorded != told:
        yield f"{where}: {_short(told)}, recorded {_short(recorded)}"


def _in_maps(recorded: Any, told: Any, tolerance: Tolerance, where: str) -> Iterator[str]:
    """A table of Lua's has no order of its keys; the server's own replies have."""
    in_order = where == "reply"
    if (list(recorded) != list(told)) if in_order else (recorded.keys() != told.keys()):
        yield f"{where}: keys {list(told)}, recorded {list(recorded)}"
        return
    for key, each in recorded.items():
        yield from differences(each, told[key], tolerance, f"{where}.{key}")


def _in_lists(recorded: Any, told: Any, tolerance: Tolerance, where: str) -> Iterator[str]:
    if len(recorded) != len(told):
        yield f"{where}: {len(told)} values, recorded {len(recorded)}"
        return
    for i, (one, other) in enumerate(zip(recorded, told, strict=True)):
        yield from differences(one, other, tolerance, f"{where}[{i}]")


def _in_bytes(recorded: bytes, told: bytes, tolerance: Tolerance, where: str) -> Iterator[str]:
    if len(recorded) != len(told):
        yield f"{where}: {len(told)} bytes, recorded {len(recorded)}"
    elif tolerance.depth and len(recorded) == DEPTHS_BYTES:
        yield from _in_depths(recorded, told, tolerance.depth, where)
    elif (off := _mean_off(recorded, told)) > tolerance.pixels:
        yield f"{where}: {off:.1f} levels off on average"


DEPTHS_BYTES = 36
"""The recorded depths are nine floats; pictures are longer."""


def _in_depths(recorded: bytes, told: bytes, tolerance: float, where: str) -> Iterator[str]:
    one, other = (np.frombuffer(each, "<f4") for each in (recorded, told))
    at_the_wall = min(one.min(), other.min()) < AT_THE_WALL_M
    if not at_the_wall and (off := float(np.abs(one - other).max())) > tolerance:
        yield f"{where}: {off:.3f} m off"


def _mean_off(recorded: bytes, told: bytes) -> float:
    one, other = (np.frombuffer(each, np.uint8).astype(float) for each in (recorded, told))
    return float(np.abs(one - other).mean()) if len(one) else 0.0


def _is_near(recorded: float, told: float, tolerance: float) -> bool:
    if math.isnan(recorded) or math.isnan(told):
        return math.isnan(recorded) and math.isnan(told)
    return abs(recorded - told) <= tolerance


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) < 90 else f"{text[:90]}…"
