"""The light of a world."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from robotcore.description.base import Angle, Colour, Described

Fraction = Annotated[float, Field(ge=0, le=1)]
Elevation = Annotated[float, Field(gt=0, le=math.pi / 2)]
Brightness = Annotated[float, Field(gt=0, le=2)]


class Light(Described):
    """One distant lamp and a glow from everywhere; a face shows ambient + diffuse·cos(angle), at most 1."""

    azimuth_rad: Angle = 0.8
    elevation_rad: Elevation = 1.0
    ambient: Fraction = 0.6
    diffuse: Fraction = 0.4
    brightness: Brightness = 1.0
    sky_colour: Colour = (205, 220, 235)

    @property
    def direction(self) -> tuple[float, float, float]:
        """The unit vector towards the lamp."""
        flat = math.cos(self.elevation_rad)
        return (
            flat * math.cos(self.azimuth_rad),
            flat * math.sin(self.azimuth_rad),
            math.sin(self.elevation_rad),
        )
