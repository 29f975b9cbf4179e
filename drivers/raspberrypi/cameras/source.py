"""The interface to a camera's own library, which each kind of camera implements, and its time stamps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple

from robotcore.hal.clock import Clock
from robotcore.hal.devices import Image


class Shot(NamedTuple):
    """A picture as the camera took it: BGR, its moment on the robot's clock, and what the camera tells of it."""

    image: Image
    time: float
    metadata: Mapping[str, Any] = {}


class ExposureState(NamedTuple):
    """How far exposure and white balance have settled.

    ``values`` come to rest then; ``is_found`` is the camera's own word on it, None where it has none.
    """

    values: tuple[float, ...]
    is_settled: bool | None = None


class Source(ABC):
    """A camera that takes pictures one after another; one thread at a time uses it.

    Every method but `close` raises DeviceError by the camera's ``name``.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def open(self) -> list[str]:
        """Let it run, with exposure and white balance by itself where they are not set by hand.

        Return the names of the settings that the camera does not take.
        """

    @abstractmethod
    def shoot(self) -> Shot:
        """Wait for the next picture, but not for ever; the memory is the caller's."""

    @abstractmethod
    def read_exposure(self, shot: Shot) -> ExposureState:
        """Return how far it has settled by a shot."""

    @abstractmethod
    def hold(self, shot: Shot) -> list[str]:
        """Keep exposure and white balance as they are in this shot; return what the camera does not let itself hold."""

    @abstractmethod
    def close(self) -> None:
        """Let the camera go, whatever state it is in; may be called again. Never raises."""


FRESH_S = 1.0
"""A camera's first stamp is not older, where it counts on the kernel's clock."""


class TimestampConverter:
    """Turns stamps in CLOCK_MONOTONIC, in seconds, into the robot's time.

    A camera whose first stamp is not of the last second counts from somewhere else: then the picture's arrival is
    taken, which is later by exposure and transfer, up to two frames. Every later stamp is believed, however old.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._is_trusted: bool | None = None

    def time_of(self, monotonic_s: float) -> float:
        """Return the time of capture, never in the future."""
        now, stamped = self._clock.now(), self._clock.time_of(monotonic_s)
        if self._is_trusted is None:
            self._is_trusted = now - stamped < FRESH_S
        return stamped if self._is_trusted else now
