"""What stands between a simulated world and the app: a camera, a range sensor and wheels that are not perfect."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from robotcore.description.base import Described

GreyLevels = Annotated[float, Field(ge=0, le=64)]
Exposure = Annotated[float, Field(ge=0.05, le=10)]
Warmth = Annotated[float, Field(ge=-0.9, le=0.9)]
Blur = Annotated[float, Field(ge=0, le=20)]
RangeNoise = Annotated[float, Field(ge=0, le=1)]
RangeBias = Annotated[float, Field(ge=-1, le=1)]
Gain = Annotated[float, Field(ge=0.5, le=1.5)]
Lag = Annotated[float, Field(ge=0, le=1)]


class Conditions(Described):
    """How sensors and wheels do in a world; as it stands, they are perfect. Simulated ones only.

    A camera is out of focus by a Gaussian of ``camera_blur_px``, takes ``camera_exposure`` times the light, sees red
    stronger and blue weaker by the part ``camera_warmth``, and adds noise of the standard deviation
    ``camera_noise``, in grey levels. A range sensor errs by ``range_bias_m``, and by noise of the standard
    deviation ``range_noise_m``. A wheel turns its gain times as fast as it is told, and lags behind by
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
