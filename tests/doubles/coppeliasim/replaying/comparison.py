"""Compare replies, with tolerances for numbers. Types, lengths, keys and their order, texts and integers must be equal.

Physics needs tolerances, because the real robot slips, bounces off a wall, and sinks into the floor. Pixels need them,
because another renderer with other lamps drew them. All other replies must be equal byte by byte.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np


class Tolerance(NamedTuple):
    """Tolerances: numbers in their unit, pixels as the mean difference in grey levels, depths in metres."""

    number: float = 0.0
    pixels: float = 0.0
    depth: float = 0.0


EXACT = Tolerance()
ANGLE_RAD = Tolerance(0.12)
TURNING_RAD_S = Tolerance(0.05)
PLACE_M = Tolerance(0.015)
TURN_RAD = Tolerance(0.01)
PICTURE = Tolerance(pixels=12.0)
DEPTHS = Tolerance(0.012, depth=0.03)
SCRIPTED = Tolerance(0.12, 12.0, 0.03)

TOLERANCES = {
    "sim.getJointPosition": ANGLE_RAD,
    "sim.getJointVelocity": TURNING_RAD_S,
    "sim.getObjectPosition": PLACE_M,
    "sim.getObjectOrientation": TURN_RAD,
    "sim.getVisionSensorImg": PICTURE,
    "sim.getVisionSensorDepth": DEPTHS,
    "sim.getVisionSensorDepthBuffer": DEPTHS,
    "sim.handleVisionSensor": DEPTHS,
    "sim.readVisionSensor": DEPTHS,
    "sim.callScriptFunction": SCRIPTED,
    "eval": SCRIPTED,
}
"""The tolerances by function. The results of all other functions are compared exactly."""

CONTACT = "sim.getContactInfo"
"""The function whose contact points have a tolerance. Forces are not compared, because they depend on the engine."""

CONTACT_M = 0.15

AT_THE_WALL_M, AT_THE_WALL = 0.035, 0.0084
"""The distance below which a sensor may be inside the wall, in metres and as a fraction of the range.

The recorded robot bounces off the wall.
"""

ANYTHING = Tolerance(1.0)


def find_differences(recorded: Any, reply: Any, tolerance: Tolerance = EXACT, where: str = "reply") -> Iterator[str]:
    """Yield the differences between a recorded value and a reply."""
    if type(recorded) is not type(reply):
        yield f"{where}: {_short(reply)}, recorded {_short(recorded)}"
    elif isinstance(recorded, dict):
        yield from _compare_maps(recorded, reply, tolerance, where)
    elif isinstance(recorded, list):
        yield from _compare_lists(recorded, reply, tolerance, where)
    elif isinstance(recorded, bytes):
        yield from _compare_bytes(recorded, reply, tolerance, where)
    elif isinstance(recorded, float):
        if not _is_near(recorded, reply, tolerance.number):
            yield f"{where}: {reply}, recorded {recorded}"
    elif recorded != reply:
        yield f"{where}: {_short(reply)}, recorded {_short(recorded)}"


def _compare_maps(recorded: Any, reply: Any, tolerance: Tolerance, where: str) -> Iterator[str]:
    """Compare maps. Keys of a Lua table have no order; keys of the server's own replies have one."""
    in_order = where == "reply"
    if (list(recorded) != list(reply)) if in_order else (recorded.keys() != reply.keys()):
        yield f"{where}: keys {list(reply)}, recorded {list(recorded)}"
        return
    for key, each in recorded.items():
        yield from find_differences(each, reply[key], tolerance, f"{where}.{key}")


def _compare_lists(recorded: Any, reply: Any, tolerance: Tolerance, where: str) -> Iterator[str]:
    if len(recorded) != len(reply):
        yield f"{where}: {len(reply)} values, recorded {len(recorded)}"
        return
    for i, (one, other) in enumerate(zip(recorded, reply, strict=True)):
        yield from find_differences(one, other, tolerance, f"{where}[{i}]")


def _compare_bytes(recorded: bytes, reply: bytes, tolerance: Tolerance, where: str) -> Iterator[str]:
    if len(recorded) != len(reply):
        yield f"{where}: {len(reply)} bytes, recorded {len(recorded)}"
    elif tolerance.depth and len(recorded) == DEPTHS_BYTES:
        yield from _compare_depths(recorded, reply, tolerance.depth, where)
    elif (off := _compute_mean_difference(recorded, reply)) > tolerance.pixels:
        yield f"{where}: {off:.1f} levels off on average"


DEPTHS_BYTES = 36
"""The size of recorded depths: nine floats. Pictures are larger."""


def _compare_depths(recorded: bytes, reply: bytes, tolerance: float, where: str) -> Iterator[str]:
    one, other = (np.frombuffer(each, "<f4") for each in (recorded, reply))
    at_the_wall = min(one.min(), other.min()) < AT_THE_WALL_M
    if not at_the_wall and (off := float(np.abs(one - other).max())) > tolerance:
        yield f"{where}: {off:.3f} m off"


def _compute_mean_difference(recorded: bytes, reply: bytes) -> float:
    one, other = (np.frombuffer(each, np.uint8).astype(float) for each in (recorded, reply))
    return float(np.abs(one - other).mean()) if len(one) else 0.0


def _is_near(recorded: float, reply: float, tolerance: float) -> bool:
    if math.isnan(recorded) or math.isnan(reply):
        return math.isnan(recorded) and math.isnan(reply)
    return abs(recorded - reply) <= tolerance


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) < 90 else f"{text[:90]}…"
