"""The light and the other conditions of a simulation, and the ranges from which a seed draws them."""

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
    """The light of a world: one distant lamp, and ambient light.

    A face shows its colour times ``ambient + diffuse·cos(a)``, at most 1. ``a`` is the angle from its normal to the
    lamp.
    """

    azimuth_rad: Angle = 0.8
    """The lamp's direction in the world's plane, from x to the left."""
    elevation_rad: Elevation = 1.0
    """The lamp's height above the horizon."""
    ambient: Fraction = 0.6
    """The share of the colour that a face shows without the lamp."""
    diffuse: Fraction = 0.4
    """The share of the colour that the lamp adds to a face that it meets at a right angle."""
    brightness: Brightness = 1.0
    """A factor on all light."""
    sky_colour: Colour = (205, 220, 235)
    """The colour above the horizon."""

    @property
    def direction(self) -> tuple[float, float, float]:
        """The unit vector from the origin to the lamp."""
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
    """The imperfections of simulated sensors and wheels; by default, there are none."""

    camera_blur_px: Blur = 0.0
    """The standard deviation of the Gaussian blur of a picture."""
    camera_exposure: Exposure = 1.0
    """A factor on the brightness of a picture."""
    camera_warmth: Warmth = 0.0
    """The part by which red is stronger and blue is weaker in a picture."""
    camera_noise: GreyLevels = 0.0
    """The standard deviation of a picture's noise, in grey levels."""
    range_bias_m: RangeBias = 0.0
    """A constant error of a distance."""
    range_noise_m: RangeNoise = 0.0
    """The standard deviation of a distance's noise."""
    wheel_gain_left: Gain = 1.0
    """The left wheel's velocity, divided by its command."""
    wheel_gain_right: Gain = 1.0
    """The right wheel's velocity, divided by its command."""
    wheel_lag_s: Lag | None = None
    """The lag of both wheels. If it is None, each motor's own ``lag_s`` holds."""


Turn = Annotated[float, Field(ge=-60, le=60)]
HueGap = Annotated[float, Field(ge=0, le=170)]
Factor = Annotated[float, Field(gt=0, le=5)]


def _false_to_none(value: Any) -> Any:
    return None if value is False else value


Off = BeforeValidator(_false_to_none)
Drawn = Annotated[Between[Number] | None, Off, Field(description="[from, to], or false")]
"""The range from which a seed draws. With None, in a file ``false``, the world's own value holds."""

Patterns = Annotated[
    Annotated[tuple[Pattern, ...], Field(min_length=1)] | None,
    Off,
    Field(description="a list of one pattern or more, or false"),
]


class Randomisation(StrictModel):
    """The ranges from which ``--randomise`` draws. The defaults are hard but solvable."""

    light_brightness: Drawn[Brightness] = (0.35, 1.4)
    """`Light.brightness`."""
    light_ambient: Drawn[Fraction] = (0.4, 0.8)
    """`Light.ambient`. The lamp's share is then 1 - ambient."""
    hue_gap_deg: Annotated[HueGap | None, Off, Field(description="a number, or false")] = 60.0
    """The least distance of the hues of floor, walls, sky and obstacles from the hue of each target."""
    colour_saturation: Drawn[Fraction] = (0.0, 0.9)
    """The HSV saturation of floor, walls, sky and obstacles."""
    colour_value: Drawn[Fraction] = (0.25, 0.95)
    """The HSV value of floor, walls, sky and obstacles."""
    target_hue_deg: Drawn[Turn] = (-8.0, 8.0)
    """The change of a target's hue."""
    target_saturation: Drawn[Factor] = (0.8, 1.25)
    """A factor on a target's saturation."""
    target_value: Drawn[Factor] = (0.75, 1.35)
    """A factor on a target's value."""
    patterns: Patterns = PATTERNS
    """The patterns of floor, walls and obstacles. Each of the three gets one."""
    pattern_scale_m: Drawn[TileSize] = (0.1, 0.6)
    """`Texture.scale_m`."""
    pattern_contrast: Drawn[Contrast] = (0.1, 0.5)
    """`Texture.contrast`."""
    camera_blur_px: Drawn[Blur] = (0.0, 1.2)
    """`Conditions.camera_blur_px`."""
    camera_exposure: Drawn[Exposure] = (0.6, 1.5)
    """`Conditions.camera_exposure`."""
    camera_warmth: Drawn[Warmth] = (-0.2, 0.2)
    """`Conditions.camera_warmth`."""
    camera_noise: Drawn[GreyLevels] = (0.0, 8.0)
    """`Conditions.camera_noise`."""
    range_bias_m: Drawn[RangeBias] = (-0.01, 0.01)
    """`Conditions.range_bias_m`."""
    range_noise_m: Drawn[RangeNoise] = (0.0, 0.02)
    """`Conditions.range_noise_m`."""
    wheel_gain: Drawn[Gain] = (0.93, 1.07)
    """`Conditions.wheel_gain_left` and `Conditions.wheel_gain_right`. Each is drawn on its own."""
    wheel_lag_s: Drawn[Lag] = (0.02, 0.12)
    """`Conditions.wheel_lag_s`."""
