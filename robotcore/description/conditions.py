"""The light and the other conditions of a simulation, and the ranges from which a seed draws them."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from robotcore.description.texture import PATTERNS, Contrast, Pattern, TileSize
from robotcore.description.types import (
    Between,
    Colour,
    Number,
    Radians,
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

    azimuth_rad: Radians = 0.8
    """The direction of the lamp in the horizontal plane: the angle from the world's x axis to the left."""
    elevation_rad: Elevation = 1.0
    """The angle of the lamp above the horizon."""
    ambient: Fraction = 0.6
    """The fraction of its colour that a face shows if the lamp does not light it."""
    diffuse: Fraction = 0.4
    """The fraction of its colour that the lamp adds to a face that is at right angles to the light."""
    brightness: Brightness = 1.0
    """The factor by which both kinds of light are multiplied."""
    sky_colour: Colour = (205, 220, 235)
    """The colour of the sky in pictures."""

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
    """The factor by which the brightness of a picture is multiplied."""
    camera_warmth: Warmth = 0.0
    """The fraction by which red is raised and blue is lowered in a picture."""
    camera_noise: GreyLevels = 0.0
    """The standard deviation of a picture's noise, in grey levels."""
    range_bias_m: RangeBias = 0.0
    """The constant error of a range sensor's distance."""
    range_noise_m: RangeNoise = 0.0
    """The standard deviation of the noise of a range sensor's distance."""
    wheel_gain_left: Gain = 1.0
    """The left wheel's velocity, divided by its command."""
    wheel_gain_right: Gain = 1.0
    """The right wheel's velocity, divided by its command."""
    wheel_lag_s: Lag | None = None
    """The lag of both wheels. If it is None, each motor has the ``lag_s`` of its own description."""


Turn = Annotated[float, Field(ge=-60, le=60)]
HueGap = Annotated[float, Field(ge=0, le=170)]
Factor = Annotated[float, Field(gt=0, le=5)]


def _false_to_none(value: Any) -> Any:
    return None if value is False else value


Off = BeforeValidator(_false_to_none)
Drawn = Annotated[Between[Number] | None, Off, Field(description="[from, to], or false")]
"""The range from which a seed draws a value. None, in a file ``false``, means that the world keeps its own value."""

Patterns = Annotated[
    Annotated[tuple[Pattern, ...], Field(min_length=1)] | None,
    Off,
    Field(description="a list of one pattern or more, or false"),
]


class Randomisation(StrictModel):
    """The ranges from which ``--randomise`` draws light, colours and errors. With the defaults, tasks stay solvable."""

    light_brightness: Drawn[Brightness] = (0.35, 1.4)
    """`Light.brightness`."""
    light_ambient: Drawn[Fraction] = (0.4, 0.8)
    """`Light.ambient`. `Light.diffuse` is then set to 1 minus the drawn value."""
    hue_gap_deg: Annotated[HueGap | None, Off, Field(description="a number, or false")] = 60.0
    """The hues of floor, walls, sky and obstacles differ from each target's hue by at least this angle."""
    colour_saturation: Drawn[Fraction] = (0.0, 0.9)
    """The HSV saturation of floor, walls, sky and obstacles."""
    colour_value: Drawn[Fraction] = (0.25, 0.95)
    """The HSV value of floor, walls, sky and obstacles."""
    target_hue_deg: Drawn[Turn] = (-8.0, 8.0)
    """The angle that is added to a target's hue."""
    target_saturation: Drawn[Factor] = (0.8, 1.25)
    """The factor by which a target's HSV saturation is multiplied."""
    target_value: Drawn[Factor] = (0.75, 1.35)
    """The factor by which a target's HSV value is multiplied."""
    patterns: Patterns = PATTERNS
    """The patterns to choose from: one for the floor, one for the walls and one for all obstacles."""
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
    """`Conditions.wheel_gain_left` and `Conditions.wheel_gain_right`. Two separate values are drawn."""
    wheel_lag_s: Drawn[Lag] = (0.02, 0.12)
    """`Conditions.wheel_lag_s`."""
