"""Layers for which every sample counts, also those that nobody asks for."""

from __future__ import annotations

from contextlib import suppress
from typing import Any, Generic

from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import SampleT
from robotcore.runtime.faults.clocks import EndingTicks
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.readers import Reader


class EagerLayer(Layer):
    """Reads what is `polled` in every tick: at its end, where nobody has by then."""

    def __init__(self) -> None:
        self._polled: list[Polled[Any]] = []

    def polled(self, read: Reader[SampleT]) -> Reader[SampleT]:
        """Return what reads the same, and is read in every tick."""
        polled = Polled(read)
        self._polled.append(polled)
        return polled

    def clock(self, clock: Clock) -> Clock:
        return EndingTicks(clock, self._end_tick)

    def _end_tick(self) -> None:
        for polled in self._polled:
            polled.end_tick()


class Polled(Generic[SampleT]):
    """Reads a sensor when it is asked, or at the end of the tick; a failure is told to those only who ask."""

    def __init__(self, read: Reader[SampleT]) -> None:
        self._read = read
        self._was_read = False

    def __call__(self) -> SampleT:
        self._was_read = True
        return self._read()

    def end_tick(self) -> None:
        if not self._was_read:
            with suppress(DeviceError):
                self._read()
        self._was_read = False
