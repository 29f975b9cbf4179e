"""The devices of a recording: sensors give back what they gave, motors and displays take all that they are told."""

from __future__ import annotations

from drivers.replay.clock import ReplayClock
from drivers.replay.reel import Reel
from robotcore.description import CameraDescription, RangeSensorDescription
from robotcore.hal.devices import (
    Angle,
    Battery,
    Camera,
    Display,
    Encoder,
    Frame,
    Image,
    Motor,
    Range,
    RangeSensor,
    Voltage,
)
from robotcore.recording import Recording


class ReplayMotor(Motor):
    """A motor that turns nothing."""

    def _apply(self, rad_s: float) -> None:
        """Nothing is there to be turned."""


class ReplayRangeSensor(RangeSensor):
    """The distances of a recording."""

    def __init__(self, description: RangeSensorDescription, reel: Reel[Range]) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._reel = reel

    def _newest(self) -> Range:
        return self._reel()


class ReplayCamera(Camera):
    """The pictures of a recording."""

    def __init__(self, description: CameraDescription, reel: Reel[Frame]) -> None:
        super().__init__(description.name, description.intrinsics)
        self._reel = reel

    def _newest(self) -> Frame:
        return self._reel()


class ReplayEncoder(Encoder):
    """The angles of a recording."""

    def __init__(self, name: str, reel: Reel[Angle]) -> None:
        super().__init__(name)
        self._reel = reel

    def _newest(self) -> Angle:
        return self._reel()


class ReplayBattery(Battery):
    """The voltages of a recording."""

    def __init__(self, name: str, reel: Reel[Voltage]) -> None:
        super().__init__(name)
        self._reel = reel

    def _newest(self) -> Voltage:
        return self._reel()


class ReplayDisplay(Display):
    """A display that nobody looks at; where it could not show a picture it cannot now."""

    def __init__(self, name: str, recording: Recording, clock: ReplayClock) -> None:
        super().__init__(name)
        self._clock, self._tick, self._count = clock, -1, 0
        self._shown = [[each.error for each in tick.shown if each.device == name] for tick in recording.ticks]

    def _show(self, image: Image) -> None:
        tick = self._clock.tick
        self._count = self._count + 1 if self._tick == tick else 0
        self._tick = tick
        if (errors := self._shown[tick][self._count : self._count + 1]) and errors[0]:
            raise errors[0].again()
