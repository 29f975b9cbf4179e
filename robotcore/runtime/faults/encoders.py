"""Encoders that do not count all of what their wheels turn."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from pydantic import Field

from robotcore.hal.devices import Angle, Encoder
from robotcore.runtime.faults.eager import EagerLayer
from robotcore.runtime.faults.fault import Fault, Kind
from robotcore.runtime.faults.occasion import Occasion
from robotcore.runtime.layers.readers import Reader

Share = Annotated[float, Field(ge=0, le=1, description="share")]


class Slip(Fault):
    """Misses this share of what its wheel turns."""

    on = frozenset({Kind.ENCODER})
    example = "encoders slip=0.1"

    value: Share

    def layer(self, occasion: Occasion) -> Slipping:
        return Slipping(self, self.value)


class Slipping(EagerLayer):
    """Takes a ``share`` away from what wheels turn while ``fault`` is there."""

    def __init__(self, fault: Fault, share: float) -> None:
        super().__init__()
        self._fault, self._share = fault, share

    def encoder(self, encoder: Encoder, read: Reader[Angle]) -> Reader[Angle]:
        return self.polled(_Missing(read, self._fault, self._share))


class _Missing:
    """Reads an angle without what was missed of it: of each turn that began while the fault was there."""

    def __init__(self, read: Reader[Angle], fault: Fault, share: float) -> None:
        self._read, self._fault, self._share = read, fault, share
        self._last = Angle(0.0, 0.0, 0)
        self._missed = 0.0

    def __call__(self) -> Angle:
        sample, last = self._read(), self._last
        if self._fault.is_on(last.time):
            self._missed += self._share * (sample.angle - last.angle)
        self._last = sample
        return replace(sample, angle=sample.angle - self._missed)
