"""What a fault on purpose is: checked parameters, a time from when it is there, and a layer over devices."""

from __future__ import annotations

from abc import abstractmethod
from enum import Enum
from math import inf
from typing import Annotated, ClassVar

from pydantic import Field

from robotcore.description import StrictModel
from robotcore.runtime.faults.occasion import Occasion
from robotcore.runtime.layers.layer import Layer

ROUNDING_S = 1e-6
"""Times are sums and quotients: those that differ by less are the same."""

LONGEST_S = 1e5
"""Nothing on a robot's clock is later."""


class Kind(str, Enum):
    """What a fault can be on."""

    CAMERA = "camera"
    RANGE = "range sensor"
    ENCODER = "encoder"
    BATTERY = "battery"
    MOTOR = "motor"
    DISPLAY = "display"
    LOOP = "loop"
    CONNECTION = "connection"


SENSORS = frozenset({Kind.CAMERA, Kind.RANGE, Kind.ENCODER, Kind.BATTERY})

Moment = Annotated[float, Field(ge=0, le=LONGEST_S, description="seconds")]
Duration = Annotated[float, Field(ge=0.001, le=LONGEST_S, description="seconds")]
Probability = Annotated[float, Field(ge=0, le=1, description="probability")]


class Fault(StrictModel):
    """One way to fail, on devices of the kinds ``on``; ``example`` is a spec of it.

    The fields are its parameters, each with its unit as ``description``. What stands behind the effect itself, as in
    ``drop=0.2``, is the field ``value``. A fault is there ``after`` so many seconds on the robot's clock, and ``lasts``
    so many, or to the end.
    """

    on: ClassVar[frozenset[Kind]] = frozenset()
    example: ClassVar[str] = ""

    after: Moment = 0.0
    lasts: Duration | None = None

    @abstractmethod
    def layer(self, occasion: Occasion) -> Layer:
        """Return the layer that makes devices fail; it is put over those only that are to."""

    def is_on(self, time: float) -> bool:
        """Return whether the fault is there at a time, or for a sample that was captured then."""
        return -ROUNDING_S <= time - self.after < (self.lasts or inf) - ROUNDING_S
