"""From what ``--randomise`` draws: how different the same room may look and feel."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from robotcore.description.base import Between, Described, Number
from robotcore.description.conditions import (
    Blur,
    Exposure,
    Gain,
    GreyLevels,
    Lag,
    RangeBias,
    RangeNoise,
    Warmth,
)
from robotcore.description.light import Brightness, Fraction
from robotcore.description.texture import PATTERNS, Contrast, Pattern, TileSize

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


class Randomisation(Described):
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
