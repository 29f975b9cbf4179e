"""An encoder on a wheel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from robotcore.description import DeviceDescription
from robotcore.hal.device import Sensor
from robotcore.hal.kind import Kind


class EncoderDescription(DeviceDescription):
    """An incremental encoder on a wheel."""

    kind: Literal["encoder"]
    counts_per_turn: Annotated[int, Field(ge=1, le=10**7)]
    """The number of counts in one turn of the wheel."""

    def quantise(self, angle: float) -> float:
        """Return the angle in radians, rounded to the nearest whole count."""
        # Rounded down, a wheel at rest near 0 would sometimes have -1 count.
        count = math.tau / self.counts_per_turn
        return round(angle / count) * count


@dataclass(frozen=True, slots=True)
class Angle:
    """A sample of an encoder."""

    angle: float
    """The angle by which the wheel has turned since the robot was opened, in radians, positive forward."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


class Encoder(Sensor[Angle]):
    """A sensor that measures the angle of a wheel."""

    kind = "encoder"


KIND = Kind("an encoder on a wheel", EncoderDescription, Encoder, Angle)
