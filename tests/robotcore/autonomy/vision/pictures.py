"""Pictures painted for tests."""

from __future__ import annotations

import colorsys
import math

import numpy as np

from robotcore.optics import Image, Intrinsics

INTRINSICS = Intrinsics(64, 48, math.radians(60))


def bgr(hue: float, saturation: float = 1.0, value: float = 0.8) -> tuple[int, int, int]:
    """Return a colour of a hue in degrees."""
    red, green, blue = colorsys.hsv_to_rgb(hue % 360 / 360, saturation, value)
    return round(blue * 255), round(green * 255), round(red * 255)


def draw_rectangles(*patches: tuple[tuple[int, int, int], tuple[int, int, int, int]]) -> Image:
    """Return a read-only grey picture with coloured rectangles, each (left, top, width, height)."""
    image = np.full((INTRINSICS.height, INTRINSICS.width, 3), 128, np.uint8)
    for colour, (left, top, width, height) in patches:
        image[top : top + height, left : left + width] = colour
    image.flags.writeable = False
    return image


def draw_round_patch(colour: tuple[int, int, int], centre: tuple[int, int], radius: float, norm: int) -> Image:
    """Return a grey picture with a disc (``norm`` 2) or a diamond (``norm`` 1). Lengths are in pixels."""
    rows, columns = np.indices((INTRINSICS.height, INTRINSICS.width))
    away = np.linalg.norm((columns - centre[0], rows - centre[1]), ord=norm, axis=0)
    return np.where((away <= radius)[..., None], np.array(colour, np.uint8), np.uint8(128))
