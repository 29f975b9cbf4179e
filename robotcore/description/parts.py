"""The parts of a robot's model, by the names and in the colours that every simulator and other tool is given."""

from __future__ import annotations

BASE = "base_link"
"""The body; its frame has its origin on the floor under the middle of the axle."""

CASTER = "caster_link"

WHEEL_COLOUR = (25, 25, 25)
CASTER_COLOUR = (150, 150, 150)


def wheel(motor: str) -> str:
    """Return the name of the wheel that a motor turns."""
    return f"{motor}_wheel"


def wheel_joint(motor: str) -> str:
    """Return the name of the joint about which it turns it: forward where the angle grows."""
    return f"{motor}_joint"


def frame(sensor: str) -> str:
    """Return the name of the frame along whose x axis a sensor looks."""
    return f"{sensor}_frame"
