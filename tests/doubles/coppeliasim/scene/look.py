"""How a scene is lit: what CoppeliaSim leaves to lamps and the background."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robotcore.description import Light

DEFAULT_LIGHT = Light(elevation_rad=math.pi / 2, ambient=0.57, diffuse=0.43, sky_colour=(0, 0, 0))
"""As the recorded pictures are lit: from straight above, before a black background."""


@dataclass
class Look:
    """The light of a scene, and its ground beyond any floor, red, green and blue from 0 to 255."""

    light: Light = DEFAULT_LIGHT
