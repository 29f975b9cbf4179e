"""Cameras with known intrinsics, distortion and noise, which render chessboards."""

from __future__ import annotations

import math
import random

from robotcore.calibration.camera.board_renderer import BoardRenderer
from robotcore.lens import is_invertible
from robotcore.optics import Intrinsics


def build_camera(
    size: tuple[int, int],
    focal_length: float,
    centre: tuple[float, float],
    distortion: tuple[float, ...] = (),
    noise: float = 0.0,
) -> BoardRenderer:
    """Return a camera.

    size: the width and the height of a picture, in pixels.
    focal_length, centre: in pixels.
    noise: the standard deviation of a pixel's noise, in grey levels.
    """
    fov = 2 * math.atan(size[0] / 2 / focal_length)
    return BoardRenderer(Intrinsics(*size, fov, centre, distortion), noise)


def draw_camera(random_: random.Random, width: int = 640, height: int = 480) -> BoardRenderer:
    """Draw a camera like those of robots: 45° to 80° wide, with a lens that bends lines visibly."""
    while True:
        focal_length = width / 2 / math.tan(math.radians(random_.uniform(45, 80)) / 2)
        shift_u, shift_v = random_.uniform(-0.03, 0.03), random_.uniform(-0.03, 0.03)
        centre = (width - 1) / 2 + shift_u * width, (height - 1) / 2 + shift_v * height
        k1, k2 = random_.uniform(-0.30, 0.10), random_.uniform(-0.05, 0.08)
        tangential = random_.uniform(-0.002, 0.002), random_.uniform(-0.002, 0.002)
        noise = random_.uniform(1.0, 6.0)
        camera = build_camera((width, height), focal_length, centre, (k1, k2, *tangential, 0.0), noise)
        if is_invertible(camera.intrinsics):  # others are no lenses
            return camera
