"""Light and other conditions of a simulation, and the limits within which a seed draws them."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from robotcore.description.texture import PATTERNS, Contrast, Pattern, TileSize
from robotcore.description.types import (
    Angle,
    Between,
    Colour,
    Number,
    StrictModel,
)

Fraction = Annotated[float, Field(ge=0, le=1)]
Elevation = Annotated[float, Field(gt=0, le=math.pi / 2)]
Brightness = Annotated[float, Field(gt=0, le=2)]


class Light(StrictModel):
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


GreyLevels = Annotated[float, Field(ge=0, le=64)]
Exposure = Annotated[float, Field(ge=0.05, le=10)]
Warmth = Annotated[float, Field(ge=-0.9, le=0.9)]
Blur = Annotated[float, Field(ge=0, le=20)]
RangeNoise = Annotated[float, Field(ge=0, le=1)]
RangeBias = Annotated[float, Field(ge=-1, le=1)]
Gain = Annotated[float, Field(ge=0.5, le=1.5)]
Lag = Annotated[float, Field(ge=0, le=1)]


class Conditions(StrictModel):
    """How sensors and wheels do in a world; as it stands, they are perfect. Simulated ones only.

    A camera is out of focus by a Gaussian of ``camera_blur_px``, takes ``camera_exposure`` times the light, sees red
    stronger and blue weaker by the part ``camera_warmth``, and adds noise of the standard deviation
    ``camera_noise``, in grey levels. A range sensor errs by ``range_bias_m``, and by noise of the standard
    deviation ``range_noise_m``. A wheel turns its gain times as fast as it is commanded, and lags behind by
    ``wheel_lag_s``, where that is given instead of the motors' own.
    """

    camera_blur_px: Blur = 0.0
    camera_exposure: Exposure = 1.0
    camera_warmth: Warmth = 0.0
    camera_noise: GreyLevels = 0.0
    range_bias_m: RangeBias = 0.0
    range_noise_m: RangeNoise = 0.0
    wheel_gain_left: Gain = 1.0
    wheel_gain_right: Gain = 1.0
    wheel_lag_s: Lag | None = None


Turn = Annotated[float, Field(ge=-60, le=60)]
HueGap = Annotated[float, Field(ge=0, le=170)]
Factor = Annotated[float, Field(gt=0, le=5)]


def _off(value: Any) -> Any:
    return None if value is False else value


Off = BeforeValidator(_off)
Drawn = Annotated[Between[Number] | None, Off, Field(description="[from, to], or false")]
"""From which to which; None, in a file ``false``, leaves what the world says."""

Patterns = Annotated[
    Annotated[tuple[Pattern, ...], Field(min_length=1)] | None,
    Off,
    Field(description="a list of one pattern or more, or false"),
]


class Randomisation(StrictModel):
    """The ranges that ``--randomise`` draws from; as it stands, all of them, as wide as is hard but possible.

    The lamp's share is what the glow leaves, 1 - ``light_ambient``. Floor, walls, sky and obstacles take any hue
    that is ``hue_gap_deg`` or more away from every target's; targets keep theirs within ``target_hue_deg``, and their
    saturation and value within factors. Floor, walls and obstacles take one of the ``patterns`` each.
    """

    light_brightness: Drawn[Brightness] = (0.35, 1.4)
    light_ambient: Drawn[Fraction] = (0.4, 0.8)
    hue_gap_deg: Annotated[HueGap | None, Off, Field(description="a number, or false")] = 60.0
    colour_saturation: Drawn[Fraction] = (0.0, 0.9)
    colour_value: Drawn[Fraction] = (0.25, 0.95)
    target_hue_deg: Drawn[Turn] = (-8.0, 8.0)
    target_saturation: Drawn[Factor] = (0.8, 1.25)
    target_value: Drawn[Factor] = (0.75, 1.35)
    patterns: Patterns = PATTERNS
    pattern_scale_m: Drawn[TileSize] = (0.1, 0.6)
    pattern_contrast: Drawn[Contrast] = (0.1, 0.5)
    camera_blur_px: Drawn[Blur] = (0.0, 1.2)
    camera_exposure: Drawn[Exposure] = (0.6, 1.5)
    camera_warmth: Drawn[Warmth] = (-0.2, 0.2)
    camera_noise: Drawn[GreyLevels] = (0.0, 8.0)
    range_bias_m: Drawn[RangeBias] = (-0.01, 0.01)
    range_noise_m: Drawn[RangeNoise] = (0.0, 0.02)
    wheel_gain: Drawn[Gain] = (0.93, 1.07)
    wheel_lag_s: Drawn[Lag] = (0.02, 0.12)
