"""Compute colours under a light, and pack them in 32 bits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Light
from robotcore.simulation.painter.planes import Array

PixelBuffer = NDArray[np.uint32]
"""A picture with 32 bits a pixel, (height, width).

Each pixel holds a packed colour, or the number of a body or surface.
"""


class Palette(NamedTuple):
    """The value that each part of a world has on a canvas: a packed colour or a number.

    A ball has several values. The first is for places that are edge-on to the lamp, the last for the place that faces
    the lamp.
    """

    sky: int
    ground: int
    picture: PixelBuffer
    """The picture on the floor. In place of a picture, one value for all of it, (1, 1)."""
    lines: Sequence[int]
    faces: Sequence[int]
    balls: Mapping[int, NDArray[np.uint32]]


class Mark(Protocol):
    """A part of the picture that has one place in the order of painting."""

    def paint(self, canvas: PixelBuffer, palette: Palette) -> None: ...


class Stroke(Mark, Protocol):
    """A face of a block, or some rows of a ball, as the camera sees it.

    ``columns`` are the first and the last column of the picture that the stroke may cover. ``part`` is the number of
    its block or ball. The balls are numbered after the blocks.
    """

    @property
    def part(self) -> int: ...
    @property
    def columns(self) -> tuple[float, float]: ...


PackedColours = NDArray[np.uint32]
"""Colours of 32 bits. The bytes of a colour are blue, green, red and an unused byte."""

RAMP_STEPS = 1024
SHADES = 256


def shade(colours: Array, cosines: Array, light: Light) -> PackedColours:
    """Return the colours of faces under a light, (n,).

    colours: red, green and blue of each face, (n, 3).
    cosines: the cosine of the angle between each face's normal and the direction to the lamp, (n,).
    """
    return pack_colours(colours * _compute_brightness(cosines, light)[:, None])


def shade_picture(picture: NDArray[np.uint8], cosine: float, light: Light) -> PixelBuffer:
    """Return a picture on a surface under a light.

    picture: red, green and blue, (height, width, 3).
    cosine: the cosine of the angle between the surface's normal and the direction to the lamp.
    """
    (brightness,) = _compute_brightness(np.array([cosine]), light)
    shades = np.rint(np.minimum(np.arange(SHADES) * brightness, 255.0)).astype(np.uint8)
    pixels = np.zeros((*picture.shape[:2], 4), dtype=np.uint8)
    pixels[:, :, :3] = shades[picture[:, :, ::-1]]
    return pixels.view(np.uint32)[:, :, 0]


def _compute_brightness(cosines: Array, light: Light) -> Array:
    return np.asarray(np.minimum(light.ambient + light.diffuse * np.maximum(cosines, 0.0), 1.0) * light.brightness)


def shade_in_steps(colours: Array, cosines: Array, light: Light) -> PackedColours:
    """Return an array (n, SHADES): for each face, the colours from black to the face's colour under the light.

    colours, cosines: see `shade`.
    """
    parts = np.linspace(0.0, 1.0, SHADES)[:, None]
    darkened = (colours[:, None] * parts).reshape(-1, 3)
    return shade(darkened, np.repeat(cosines, SHADES), light).reshape(-1, SHADES)


def shade_ramp(colour: tuple[int, int, int], light: Light) -> PackedColours:
    """Return the shades of a colour from edge-on to the lamp to facing the lamp, (RAMP_STEPS,).

    colour: red, green and blue.
    """
    return shade(np.full((RAMP_STEPS, 3), colour, dtype=np.float64), np.linspace(0.0, 1.0, RAMP_STEPS), light)


def pack_colours(colours: Array) -> PackedColours:
    """Pack colours in 32 bits each, (n,). Values above 255 count as 255.

    colours: red, green and blue, (n, 3).
    """
    pixels = np.zeros((len(colours), 4), dtype=np.uint8)
    pixels[:, :3] = np.rint(np.minimum(colours, 255.0))[:, ::-1]
    return pixels.view(np.uint32)[:, 0]
