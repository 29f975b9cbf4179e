"""An encoder on a wheel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from robotcore.description import DeviceDescription
from robotcore.hal.clock import Clock
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind, raise_not_simulated
from robotcore.hal.sampling import SampleCache
from robotcore.kinds.device_tests.wheels import test_encoders

__all__ = ["KIND", "Angle", "Encoder", "EncoderDescription"]


class EncoderDescription(DeviceDescription):
    """An incremental encoder on a wheel.

    >>> encoder = EncoderDescription(kind="encoder", name="left_encoder", counts_per_turn=960)
    >>> encoder.quantise(0.01)  # radians
    0.01308996938995747
    """

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
    """A sample of an encoder.

    >>> Angle(angle=3.1, time=1.25, sequence=25)
    Angle 3.10 rad at 1.25 s
    """

    angle: Annotated[float, Unit("rad")]
    """The angle by which the wheel has turned since the robot was opened, in radians, positive forward."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


class Encoder(Sensor[Angle]):
    """A sensor that measures the angle of a wheel. Odometry reads the encoders of the drive.

    >>> from robotcore.testing import MockRobot
    >>> robot = MockRobot("rover", readings={"left_encoder": 3.1}).layered
    >>> robot["left_encoder"].read()
    Angle 3.10 rad at 0.00 s
    """

    kind = "encoder"


class SimulatedEncoder(Encoder):
    """An encoder of a simulated wheel, which measures in whole counts.

    read_angle: returns the angle of the wheel in radians.
    """

    def __init__(self, description: EncoderDescription, clock: Clock, read_angle: Callable[[], float]) -> None:
        super().__init__(description.name)

        def take(time: float, sequence: int) -> Angle:
            return Angle(description.quantise(read_angle()), time, sequence)

        self._newest_at = SampleCache(clock, take)

    def _newest(self) -> Angle:
        return self._newest_at()


KIND = Kind(
    "an encoder on a wheel", EncoderDescription, Encoder, Angle, raise_not_simulated, test_devices=test_encoders
)
"""The kind `encoder`, which the entry point of this name refers to."""
