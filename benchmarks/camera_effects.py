"""The effects of light, lens, sensor and compression on a picture. The steps use float32 in BGR, from 0 to 255."""

from __future__ import annotations

import math
from random import Random
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.optics import Image

Light = NDArray[np.float32]
Mask = NDArray[np.bool_]
Gains = tuple[float, float, float]
"""The factors of the channels, in the order blue, green, red."""


class Conditions(NamedTuple):
    """The conditions of a picture: lengths in pixels, noise and lamp in grey levels, JPEG quality or None."""

    brightness: float
    gains: Gains
    gamma: float
    contrast: float
    noise: float
    defocus: float
    motion: float
    heading: float
    quality: int | None
    glare: float
    lamp: float
    vignette: float

    @classmethod
    def mild(cls, draw: Random) -> Conditions:
        """Draw mild conditions: a sharp lens, little motion, even light."""
        return cls(
            brightness=draw.uniform(0.7, 1.15),
            gains=_draw_gains(draw, 0.08),
            gamma=draw.uniform(0.9, 1.1),
            contrast=draw.uniform(0.92, 1.08),
            noise=draw.uniform(1.0, 3.0),
            defocus=draw.uniform(0.3, 0.6),
            motion=0.0,
            heading=0.0,
            quality=draw.choice((None, draw.randint(75, 90))),
            glare=draw.choice((0.0, draw.uniform(0.2, 0.5))),
            lamp=0.0,
            vignette=draw.uniform(0.0, 0.15),
        )

    @classmethod
    def harsh(cls, draw: Random, diameter_px: float) -> Conditions:
        """Draw harsh conditions. The blur leaves a ball of ``diameter_px`` visible; 0 means that there is none."""
        bearable = 0.3 * (diameter_px or draw.uniform(4, 60))
        return cls(
            brightness=draw.uniform(0.3, 1.3),
            gains=_draw_gains(draw, 0.25),
            gamma=draw.uniform(0.75, 1.35),
            contrast=draw.uniform(0.75, 1.2),
            noise=draw.uniform(2.0, 10.0),
            defocus=min(draw.uniform(0.3, 2.5), bearable),
            motion=draw.choice((0.0, min(draw.uniform(2, 10), bearable))),
            heading=draw.uniform(0, math.pi),
            quality=draw.choice((None, draw.randint(30, 75))),
            glare=draw.choice((0.0, draw.uniform(0.5, 1.0))),
            lamp=draw.choice((0.0, draw.uniform(60, 180))),
            vignette=draw.uniform(0.0, 0.5),
        )


def apply_camera_effects(image: Image, ball: Mask, how: Conditions, draw: Random) -> Image:
    """Return the picture with all effects of a camera under the conditions ``how``."""
    light = image.astype(np.float32) * np.array(how.gains, np.float32)
    light = _add_lamp(_add_glare(light, ball, how.glare, draw), how.lamp, draw)
    light = _add_vignette(light * np.float32(how.brightness), how.vignette)
    light = _develop(_blur(light, how), how)
    return _compress(_add_noise(light, how.noise, draw), how.quality)


def add_texture(image: Image, where: Mask, rgb: tuple[int, int, int], draw: Random) -> Image:
    """Return the picture with grass of one colour, in light and dark blades, in the mask ``where``."""
    dice, (height, width) = np.random.default_rng(draw.randrange(2**32)), where.shape
    shade = np.zeros((height, width))
    for size in (1, 3, 9):
        coarse = dice.normal(1 / 3, 0.09, (math.ceil(height / size), math.ceil(width / (size + 1))))
        shade += cv2.resize(coarse, (width, height))
    tone = dice.normal(1.0, 0.06, (height, width, 3))
    blades = np.clip(np.array(rgb[::-1]) * tone * shade[..., None], 0, 255).astype(np.uint8)
    return np.where(where[..., None], blades, image)


def _add_glare(light: Light, ball: Mask, strength: float, draw: Random) -> Light:
    """Add the reflection of a lamp to the ball: a white spot of about a third of its width."""
    if not strength or not ball.any():
        return light
    rows, columns = np.nonzero(ball)
    pick = draw.randrange(len(rows))
    size = max(0.6, 0.1 * math.sqrt(len(rows)))
    spot = _spot(ball.shape, (float(columns[pick]), float(rows[pick])), size) * np.float32(strength)
    part = (spot * ball)[..., None]
    return light + (255 - light) * part


def _add_lamp(light: Light, strength: float, draw: Random) -> Light:
    if not strength:
        return light
    height, width = light.shape[:2]
    place = draw.uniform(0, width), draw.uniform(0, height / 2)
    bloom = _spot((height, width), place, draw.uniform(15, 50)) + _spot((height, width), place, 4.0)
    return light + np.float32(strength) * bloom[..., None] * np.array(_draw_gains(draw, 0.2), np.float32)


def _spot(shape: tuple[int, ...], place: tuple[float, float], size: float) -> Light:
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    squares = (columns - place[0]) ** 2 + (rows - place[1]) ** 2
    return np.asarray(np.exp(-squares / (2 * size**2)), np.float32)


def _add_vignette(light: Light, strength: float) -> Light:
    height, width = light.shape[:2]
    rows, columns = np.ogrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    return light * np.asarray(1 - strength * (rows**2 + columns**2) / 2, np.float32)[..., None]


def _blur(light: Light, how: Conditions) -> Light:
    soft = cv2.GaussianBlur(light, (0, 0), how.defocus)
    if how.motion >= 2:
        soft = cv2.filter2D(soft, -1, _path(how.motion, how.heading))
    return np.asarray(soft, np.float32)


def _path(length: float, heading: float) -> Light:
    """Return the kernel of a motion blur: a line across the middle of the kernel, with the sum 1."""
    size = 2 * math.ceil(length / 2) + 1
    across, down = length / 2 * math.cos(heading), length / 2 * math.sin(heading)
    first, last = ((round(size // 2 + sign * across), round(size // 2 + sign * down)) for sign in (-1, 1))
    kernel = np.zeros((size, size), np.float32)
    cv2.line(kernel, first, last, (1.0,))
    return np.asarray(kernel / kernel.sum(), np.float32)


def _develop(light: Light, how: Conditions) -> Light:
    light = np.clip((light - 128) * np.float32(how.contrast) + 128, 0, 255)
    return np.asarray(255 * (light / 255) ** how.gamma, np.float32)


def _add_noise(light: Light, sigma: float, draw: Random) -> Light:
    """Add shot noise, proportional to the root of the light, and read noise: ``sigma`` at mid grey."""
    dice = np.random.default_rng(draw.randrange(2**32))
    deviation = np.float32(sigma) * np.sqrt(0.3 + 0.7 * light / 128)
    return np.asarray(light + deviation * dice.standard_normal(light.shape, dtype=np.float32), np.float32)


def _compress(light: Light, quality: int | None) -> Image:
    image = np.clip(np.rint(light), 0, 255).astype(np.uint8)
    if quality is None:
        return image
    _, packed = cv2.imencode(".jpg", image, (cv2.IMWRITE_JPEG_QUALITY, quality))
    return np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)


def _draw_gains(draw: Random, spread: float) -> Gains:
    """Draw the gains of a wrong white balance or a coloured lamp. Green changes half as much as blue and red."""
    return 1 + draw.uniform(-spread, spread), 1 + draw.uniform(-spread, spread) / 2, 1 + draw.uniform(-spread, spread)
