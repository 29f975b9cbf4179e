"""Scripts: what a sensor will read, written down beforehand."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Generic, TypeVar

from robotcore.errors import DeviceError, UsageError
from robotcore.hal.clock import Clock

ValueT = TypeVar("ValueT")


class _Lost(Enum):
    LOST = "lost"


LOST = _Lost.LOST
"""In a script: nothing came back this tick. There is no new sample; the old one grows older."""

Script = Any | Sequence[Any] | Callable[[float], Any]
"""One reading for ever; a list or tuple of readings, one a tick, of which the last stays; or a function of the time
in seconds. An exception in place of a reading makes the device fail with it."""


@dataclass(frozen=True)
class Played(Generic[ValueT]):
    """A reading that was played, when, and which one it is."""

    value: ValueT
    time: float
    sequence: int


class Playback(Generic[ValueT]):
    """Plays a script against a clock, one reading a tick; ``convert`` checks a reading and makes it a value."""

    def __init__(
        self, device: str, script: Script, clock: Clock, rate_hz: float, convert: Callable[[Any], ValueT]
    ) -> None:
        if isinstance(script, (list, tuple)) and not script:
            raise UsageError(f"{device}: its script is empty; give it one reading at least")
        self._device, self._script, self._clock, self._rate_hz = device, script, clock, rate_hz
        self._convert = convert
        self._played_until = -1
        self._newest: Played[ValueT] | None = None
        self._failure: Exception | None = None

    def newest(self) -> Played[ValueT]:
        """Play up to now; return the newest reading. Raises DeviceError where the script fails here."""
        now = self._clock.now()
        tick = math.floor(now * self._rate_hz + 1e-6)
        for due in range(self._played_until + 1, tick + 1):
            self._play(due, min(due / self._rate_hz, now))
        if self._failure:
            raise DeviceError(self._device, str(self._failure)) from self._failure
        if self._newest is None:
            raise DeviceError(self._device, "nothing has been read yet; let its script begin with a reading")
        return self._newest

    def _play(self, tick: int, time: float) -> None:
        self._played_until = tick
        reading = self._reading(tick, time)
        self._failure = reading if isinstance(reading, Exception) else None
        if self._failure or reading is LOST:
            return
        sequence = self._newest.sequence + 1 if self._newest else 0
        self._newest = Played(self._convert(reading), time, sequence)

    def _reading(self, tick: int, time: float) -> Any:
        script = self._script
        if isinstance(script, (list, tuple)):
            return script[min(tick, len(script) - 1)]
        return script(time) if callable(script) else script
