"""The devices of a recording: sensors give back what they gave, motors and displays take all that they are told."""

from __future__ import annotations

from drivers.replay.reel import Reel
from robotcore.description import CameraDescription, MotorDescription, RangeSensorDescription
from robotcore.devices import Angle, Camera, Display, Encoder, Frame, Image, Motor, Range, RangeSensor


class ReplayMotor(Motor):
    """A motor that turns nothing."""

    def __init__(self, description: MotorDescription) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)

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


class ReplayDisplay(Display):
    """A display that nobody looks at."""

    def _show(self, image: Image) -> None:
        """Nobody looks."""
