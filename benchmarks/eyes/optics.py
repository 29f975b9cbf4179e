"""What light, lens, sensor and compression do to a picture; each step takes and returns float32, BGR, 0 to 255."""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.eyes.rendering import Mask
from robotcore.devices import Image

Light = NDArray[np.float32]
Gains = tuple[float, float, float]


@dataclass(frozen=True)
class Conditions:
    """Under which a picture is taken; lengths in pixels, noise in grey levels, ``quality`` JPEG's or None."""

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
    def mild(cls, draw: Random, diameter_px: float) -> Conditions:
        """Draw a good day: a sharp lens, a calm hand, an even light."""
        return cls(
            brightness=draw.uniform(0.7, 1.15),
            gains=_gains(draw, 0.08),
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
        """Draw a bad day; blur stays within what a ball of this diameter, 0 for none, can bear and still be seen."""
        bearable = 0.3 * (diameter_px or draw.uniform(4, 60))
        return cls(
            brightness=draw.uniform(0.3, 1.3),
            gains=_gains(draw, 0.25),
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


def taken(image: Image, ball: Mask, how: Conditions, draw: Random) -> Image:
    """Return the picture as it comes out of a camera."""
    light = image.astype(np.float32) * np.float32(how.gains)
    light = _lamp(_glare(light, ball, how.glare, draw), how.lamp, draw)
    light = _vignette(light * np.float32(how.brightness), how.vignette)
    light = _developed(_blurred(light, how), how)
    return _compressed(_noisy(light, how.noise, draw), how.quality)


def textured(image: Image, where: Mask, rgb: tuple[int, int, int], draw: Random) -> Image:
    """Return the picture with blades of one colour, light and dark, where ``where`` is true."""
    dice, shape = np.random.default_rng(draw.randrange(2**32)), where.shape
    shade = sum(
        cv2.resize(dice.normal(1 / 3, 0.09, (math.ceil(shape[0] / n), math.ceil(shape[1] / (n + 1)))), shape[::-1])
        for n in (1, 3, 9)
    )
    tone = dice.normal(1.0, 0.06, (*shape, 3))
    blades = np.clip(np.array(rgb[::-1]) * tone * np.asarray(shade)[..., None], 0, 255).astype(np.uint8)
    return np.where(where[..., None], blades, image)


def _gains(draw: Random, spread: float) -> Gains:
    """A white balance that has drifted, or a coloured lamp."""
    return 1 + draw.uniform(-spread, spread), 1 + draw.uniform(-spread, spread) / 2, 1 + draw.uniform(-spread, spread)


def _glare(light: Light, ball: Mask, strength: float, draw: Random) -> Light:
    """A lamp's reflection on the ball: a white spot a fifth of the ball wide."""
    if not strength or not ball.any():
        return light
    rows, columns = np.nonzero(ball)
    pick = draw.randrange(len(rows))
    size = max(0.6, 0.1 * math.sqrt(len(rows)))
    spot = _spot(ball.shape, (float(columns[pick]), float(rows[pick])), size) * np.float32(strength)
    spot = (spot * ball)[..., None]
    return light * (1 - spot) + 255 * spot


def _lamp(light: Light, strength: float, draw: Random) -> Light:
    """A lamp within the picture, and its bloom: light added all round it, tinged."""
    if not strength:
        return light
    height, width = light.shape[:2]
    place = draw.uniform(0, width), draw.uniform(0, height / 2)
    bloom = _spot((height, width), place, draw.uniform(15, 50)) + _spot((height, width), place, 4.0)
    return light + np.float32(strength) * bloom[..., None] * np.float32(_gains(draw, 0.2))


def _spot(shape: tuple[int, ...], place: tuple[float, float], size: float) -> Light:
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    squares = (columns - place[0]) ** 2 + (rows - place[1]) ** 2
    return np.exp(-squares / (2 * size**2)).astype(np.float32)


def _vignette(light: Light, strength: float) -> Light:
    height, width = light.shape[:2]
    rows, columns = np.ogrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    return light * (1 - strength * (rows**2 + columns**2) / 2)[..., None].astype(np.float32)


def _blurred(light: Light, how: Conditions) -> Light:
    light = cv2.GaussianBlur(light, (0, 0), how.defocus)
    if how.motion < 2:
        return light
    size = 2 * math.ceil(how.motion / 2) + 1
    path = np.zeros((size, size), np.float32)
    reach = how.motion / 2 * np.array((math.cos(how.heading), math.sin(how.heading)))
    ends = [tuple(int(part) for part in np.rint(size // 2 + sign * reach)) for sign in (-1, 1)]
    cv2.line(path, *ends, 1.0)
    return cv2.filter2D(light, -1, path / path.sum())


def _developed(light: Light, how: Conditions) -> Light:
    """Contrast about mid grey, then gamma."""
    light = np.clip((light - 128) * how.contrast + 128, 0, 255)
    return (255 * (light / 255) ** how.gamma).astype(np.float32)


def _noisy(light: Light, sigma: float, draw: Random) -> Light:
    """Shot noise, which grows with the root of the light, and read noise: ``sigma`` at mid grey."""
    dice = np.random.default_rng(draw.randrange(2**32))
    deviation = sigma * np.sqrt(0.3 + 0.7 * light / 128)
    return light + deviation * dice.standard_normal(light.shape, dtype=np.float32)


def _compressed(light: Light, quality: int | None) -> Image:
    image = np.clip(np.rint(light), 0, 255).astype(np.uint8)
    if quality is None:
        return image
    _, packed = cv2.imencode(".jpg", image, (cv2.IMWRITE_JPEG_QUALITY, quality))
    return np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)
