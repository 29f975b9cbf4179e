"""Hues by name, and the range of hues that belongs to each name."""

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

HUE_RANGES = {
    "red": (-22.0, 14.0),
    "orange": (14.0, 40.5),
    "yellow": (40.5, 90.5),
    "green": (90.5, 158.0),
    "cyan": (158.0, 204.5),
    "blue": (204.5, 249.0),
    "purple": (249.0, 294.5),
    "magenta": (294.5, 338.0),
}
"""The smallest and the largest hue of each name, in degrees. Each hue of the circle belongs to one name.

A range ends in the middle between two named hues. Only that of green ends 2 degrees later, at 30 degrees from green.
"""


def hue_of(hue: str | float) -> float:
    """Return a hue in degrees, in [0, 360). The argument is a name in `HUES` or any number of degrees.

    Raises UnknownNameError for an unknown name, and UsageError for a number that is not finite.

    >>> hue_of("green"), hue_of(-10)
    (128.0, 350.0)
    """
    try:
        degrees = float(hue)
    except ValueError:
        if hue not in HUES:
            raise UnknownNameError("hue", str(hue), list(HUES)) from None
        return HUES[str(hue)]
    if not math.isfinite(degrees):
        raise UsageError(f"the hue is {hue}; take a name or degrees from 0 to 360", kind="no-hue", hue=hue)
    return degrees % 360


def limit_tolerance(hue: str | float, tolerance: float) -> tuple[float, float]:
    """Return the tolerance below and above a hue, in degrees. For a name, both end at the limits of `HUE_RANGES`.

    hue: a name in `HUES`, or degrees.
    tolerance: the greatest difference from the hue, in degrees.

    >>> limit_tolerance("orange", 30), limit_tolerance(28, 30)
    ((14.0, 12.5), (30, 30))
    """
    if hue not in HUES:
        return tolerance, tolerance
    smallest, largest = HUE_RANGES[str(hue)]
    return min(tolerance, HUES[str(hue)] - smallest), min(tolerance, largest - HUES[str(hue)])
