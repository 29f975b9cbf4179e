"""Hues by name or in degrees on the colour circle."""

from __future__ import annotations

import math

from robotcore.errors import UnknownNameError, UsageError

HUES = {
    "red": 0.0,
    "orange": 28.0,
    "yellow": 53.0,
    "green": 128.0,
    "cyan": 184.0,
    "blue": 225.0,
    "purple": 273.0,
    "magenta": 316.0,
}
"""Hues by name, in degrees on the colour circle."""


def hue_of(hue: str | float) -> float:
    """Return a hue, given by name or in degrees, in [0, 360)."""
    try:
        degrees = float(hue)
    except ValueError:
        if hue not in HUES:
            raise UnknownNameError("hue", str(hue), list(HUES)) from None
        return HUES[str(hue)]
    if not math.isfinite(degrees):
        raise UsageError(f"the hue is {hue}; it must be a name or degrees from 0 to 360")
    return degrees % 360
