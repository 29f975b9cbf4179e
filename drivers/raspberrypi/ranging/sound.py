"""How fast sound is."""

from __future__ import annotations

import math


def speed_of_sound(temperature_c: float) -> float:
    """Return the speed of sound in dry air, in m/s; 0.6 m/s more for each degree.

    The square root of the absolute temperature, through 331.45 m/s at 0 °C. Source: G. S. K. Wong, Speed of sound in
    standard air, J. Acoust. Soc. Am. 79 (1986), 1359. Humid air is up to 0.4 % faster.

    >>> round(speed_of_sound(20.0), 1)
    343.4
    """
    return 331.45 * math.sqrt(1 + temperature_c / 273.15)
