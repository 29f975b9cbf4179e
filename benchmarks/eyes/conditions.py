"""The conditions under which a picture is taken, mild or harsh."""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

Gains = tuple[float, float, float]
"""The factors of the channels, in the order blue, green, red."""


@dataclass(frozen=True)
class Conditions:
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
            gains=draw_gains(draw, 0.08),
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
            gains=draw_gains(draw, 0.25),
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


def draw_gains(draw: Random, spread: float) -> Gains:
    """Draw the gains of a wrong white balance or a coloured lamp. Green changes half as much as blue and red."""
    return 1 + draw.uniform(-spread, spread), 1 + draw.uniform(-spread, spread) / 2, 1 + draw.uniform(-spread, spread)
