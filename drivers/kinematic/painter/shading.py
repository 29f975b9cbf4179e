"""Colours under the lamp, as inks: one 32-bit number holds a pixel's blue, green, red and a spare byte."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Light

Array = NDArray[np.float64]
Inks = NDArray[np.uint32]

RAMP_STEPS = 1024
SKY = (205, 220, 235)


def inks_of(colours: Array, cosines: Array, light: Light) -> Inks:
    """Return the inks, (n,), of faces of these colours, (n, 3) red, green, blue.

    ``cosines``, (n,), are of the angles between the faces and the lamp.
    """
    shade = np.minimum(light.ambient + light.diffuse * np.maximum(cosines, 0.0), 1.0) * light.brightness
    lit = np.rint(np.minimum(colours * shade[:, None], 255.0)).astype(np.uint8)
    pixels = np.zeros((len(lit), 4), dtype=np.uint8)
    pixels[:, :3] = lit[:, ::-1]
    return pixels.view(np.uint32)[:, 0]


def ramp_of(colour: tuple[int, int, int], light: Light) -> Inks:
    """Return the inks of one colour from edge-on to facing the lamp, (RAMP_STEPS,)."""
    cosines = np.linspace(0.0, 1.0, RAMP_STEPS)
    return inks_of(np.tile(np.array(colour, dtype=np.float64), (RAMP_STEPS, 1)), cosines, light)


def sky_ink(light: Light) -> np.uint32:
    """Return the ink of the sky, which gives off the light rather than taking it."""
    bright = np.array([min(light.brightness, 1.0)])
    return np.uint32(inks_of(bright[:, None] * SKY, np.zeros(1), Light(ambient=1.0, diffuse=0.0))[0])
