"""The light of a world, the errors of simulated sensors and wheels, and the ranges from which a seed draws both."""

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
    """The light of a world: ambient light and a distant lamp.

    A surface appears in its colour times ``brightness · min(ambient + diffuse · cos(a), 1)``. The angle ``a`` is
    between the surface's normal and the direction to the lamp.

    >>> import math
    >>> light = Light(elevation_rad=math.pi / 2, brightness=0.8)
    >>> [round(each, 1) for each in light.direction]  # the lamp is above the world
    [0.0, 0.0, 1.0]
    """

    azimuth_rad: Radians = 0.8
    """The horizontal angle from the world's x axis to the direction of the lamp, in radians, positive to the left."""
    elevation_rad: Elevation = 1.0
    """The angle of the lamp above the horizon, in radians."""
    ambient: Fraction = 0.6
    """The part of a surface's colour that is visible without the lamp, from 0 to 1."""
    diffuse: Fraction = 0.4
    """The part of a surface's colour that the lamp adds if it shines at a right angle on the surface, from 0 to 1."""
    brightness: Brightness = 1.0
    """The factor by which ``ambient`` and ``diffuse`` are multiplied."""
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
RangeNoiseSigma = Annotated[float, Field(ge=0, le=1)]
RangeBias = Annotated[float, Field(ge=-1, le=1)]
Gain = Annotated[float, Field(ge=0.5, le=1.5)]
Lag = Annotated[float, Field(ge=0, le=1)]


class Conditions(StrictModel):
    """The errors of simulated cameras, range sensors and wheels. With the defaults, there are no errors.

    >>> errors = Conditions(range_noise_m=0.02, wheel_gain_left=0.95)
    >>> errors.range_noise_m, errors.camera_noise
    (0.02, 0.0)
    """

    camera_blur_px: Blur = 0.0
    """The standard deviation of the Gaussian blur of pictures, in pixels."""
    camera_exposure: Exposure = 1.0
    """The factor by which the brightness of pictures is multiplied."""
    camera_warmth: Warmth = 0.0
    """The fraction by which red is increased and blue is reduced in pictures."""
    camera_noise: GreyLevels = 0.0
    """The standard deviation of the noise of pictures, in grey levels."""
    range_bias_m: RangeBias = 0.0
    """The constant error of the measured distances, in metres."""
    range_noise_m: RangeNoiseSigma = 0.0
    """The standard deviation of the noise of the measured distances, in metres."""
    wheel_gain_left: Gain = 1.0
    """The velocity of the left wheel, divided by the commanded velocity."""
    wheel_gain_right: Gain = 1.0
    """The velocity of the right wheel, divided by the commanded velocity."""
    wheel_lag_s: Lag | None = None
    """The time constant of both wheels' lag, in seconds. With None, the ``lag_s`` of each motor applies."""


Turn = Annotated[float, Field(ge=-60, le=60)]
HueGap = Annotated[float, Field(ge=0, le=170)]
Factor = Annotated[float, Field(gt=0, le=5)]


def _false_to_none(value: Any) -> Any:
    return None if value is False else value


Off = BeforeValidator(_false_to_none)
Drawn = Annotated[Between[Number] | None, Off, Field(description="[from, to], or false")]
"""The range from which a seed draws a value. With None, which is ``false`` in a file, the world keeps its own value."""

Patterns = Annotated[
    Annotated[tuple[Pattern, ...], Field(min_length=1)] | None,
    Off,
    Field(description="a list of one pattern or more, or false"),
]


class Randomisation(StrictModel):
    """The ranges from which ``--randomise`` draws light, colours and errors. The defaults keep the tasks solvable.

    >>> ranges = Randomisation(range_noise_m=(0.0, 0.05), wheel_gain=False)  # false keeps the world's own value
    >>> ranges.range_noise_m, ranges.wheel_gain is None, ranges.light_brightness
    ((0.0, 0.05), True, (0.35, 1.4))
    """

    light_brightness: Drawn[Brightness] = (0.35, 1.4)
    """The range of the drawn `Light.brightness`."""
    light_ambient: Drawn[Fraction] = (0.4, 0.8)
    """The range of the drawn `Light.ambient`. `Light.diffuse` is then 1 minus the drawn value."""
    hue_gap_deg: Annotated[HueGap | None, Off, Field(description="a number, or false")] = 60.0
    """The least difference of the hues of floor, walls, sky and obstacles from each target's hue, in degrees."""
    colour_saturation: Drawn[Fraction] = (0.0, 0.9)
    """The range of the drawn HSV saturations of floor, walls, sky and obstacles."""
    colour_value: Drawn[Fraction] = (0.25, 0.95)
    """The range of the drawn HSV values of floor, walls, sky and obstacles."""
    target_hue_deg: Drawn[Turn] = (-8.0, 8.0)
    """The range of the angle that is added to a target's hue, in degrees."""
    target_saturation: Drawn[Factor] = (0.8, 1.25)
    """The range of the factor by which a target's HSV saturation is multiplied."""
    target_value: Drawn[Factor] = (0.75, 1.35)
    """The range of the factor by which a target's HSV value is multiplied."""
    patterns: Patterns = PATTERNS
    """The patterns of which one is drawn for the floor, one for the walls and one for all obstacles."""
    pattern_scale_m: Drawn[TileSize] = (0.1, 0.6)
    """The range of the drawn `Texture.scale_m`, in metres."""
    pattern_contrast: Drawn[Contrast] = (0.1, 0.5)
    """The range of the drawn `Texture.contrast`."""
    camera_blur_px: Drawn[Blur] = (0.0, 1.2)
    """The range of the drawn `Conditions.camera_blur_px`, in pixels."""
    camera_exposure: Drawn[Exposure] = (0.6, 1.5)
    """The range of the drawn `Conditions.camera_exposure`."""
    camera_warmth: Drawn[Warmth] = (-0.2, 0.2)
    """The range of the drawn `Conditions.camera_warmth`."""
    camera_noise: Drawn[GreyLevels] = (0.0, 8.0)
    """The range of the drawn `Conditions.camera_noise`, in grey levels."""
    range_bias_m: Drawn[RangeBias] = (-0.01, 0.01)
    """The range of the drawn `Conditions.range_bias_m`, in metres."""
    range_noise_m: Drawn[RangeNoiseSigma] = (0.0, 0.02)
    """The range of the drawn `Conditions.range_noise_m`, in metres."""
    wheel_gain: Drawn[Gain] = (0.93, 1.07)
    """The range of the drawn `Conditions.wheel_gain_left` and `Conditions.wheel_gain_right`."""
    wheel_lag_s: Drawn[Lag] = (0.02, 0.12)
    """The range of the drawn `Conditions.wheel_lag_s`, in seconds."""
