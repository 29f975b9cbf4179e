"""Colours under the lamp, as inks: one 32-bit number holds a pixel's blue, green, red and a spare byte."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Light
from robotcore.simulation.painter.planes import Array

Inks = NDArray[np.uint32]

RAMP_STEPS = 1024
SHADES = 256


def inks_of(colours: Array, cosines: Array, light: Light) -> Inks:
    """Return the inks, (n,), of faces of these colours, (n, 3) red, green, blue.

    ``cosines``, (n,), are of the angles between the faces and the lamp.
    """
    shade = np.minimum(light.ambient + light.diffuse * np.maximum(cosines, 0.0), 1.0) * light.brightness
    return packed(colours * shade[:, None])


def shades_of(colours: Array, cosines: Array, light: Light) -> Inks:
    """Return the inks of faces as `inks_of`, from nothing of their colour to all of it, (n, SHADES)."""
    parts = np.linspace(0.0, 1.0, SHADES)[:, None]
    darkened = (colours[:, None] * parts).reshape(-1, 3)
    return inks_of(darkened, np.repeat(cosines, SHADES), light).reshape(-1, SHADES)


def ramp_of(colour: tuple[int, int, int], light: Light) -> Inks:
    """Return the inks of one colour from edge-on to facing the lamp, (RAMP_STEPS,)."""
    return inks_of(np.full((RAMP_STEPS, 3), colour, dtype=np.float64), np.linspace(0.0, 1.0, RAMP_STEPS), light)


def packed(colours: Array) -> Inks:
    """Return colours, (n, 3) red, green, blue, as inks, (n,); what is too bright is as bright as can be."""
    pixels = np.zeros((len(colours), 4), dtype=np.uint8)
    pixels[:, :3] = np.rint(np.minimum(colours, 255.0))[:, ::-1]
    return pixels.view(np.uint32)[:, 0]
