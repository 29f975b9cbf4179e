"""How far figures may be apart. Everything else has to be equal: types, lengths, keys and their order, texts, integers.

Physics: the real robot slips, bounces off a wall, and settles into the floor; the double's does not. Pixels: another
renderer, other lamps. Where neither counts, replies have to be equal byte by byte.
"""

from __future__ import annotations

from typing import NamedTuple


class Tolerance(NamedTuple):
    """For numbers, in their own unit; for pixels, the mean difference in grey levels; for depths, metres."""

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
"""By function; what is not named is exact."""

CONTACT = "sim.getContactInfo"
"""Of contacts, who touches whom is compared, and where in metres; forces are an engine's own, and any point will do."""

CONTACT_M = 0.15

AT_THE_WALL_M, AT_THE_WALL = 0.035, 0.0084
"""Nearer than this, in metres and as a part of the fan's range, a sensor on a bouncing robot may be in the wall."""

ANYTHING = Tolerance(1.0)
