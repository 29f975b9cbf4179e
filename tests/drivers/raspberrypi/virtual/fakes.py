"""What a simulator has behind the pins, as a test moves it."""

from __future__ import annotations

from robotcore.hal.devices import Angle, Encoder, Motor, Range, RangeSensor


class FakeMotor(Motor):
    """Keeps what it was told."""

    def __init__(self) -> None:
        super().__init__("motor", 12.0)
        self.velocity = 0.0

    def _apply(self, rad_s: float) -> None:
        self.velocity = rad_s


class FakeEncoder(Encoder):
    """Reads the angle that a test has set."""

    def __init__(self) -> None:
        super().__init__("encoder")
        self.angle = 0.0

    def _newest(self) -> Angle:
        return Angle(self.angle, 0.0, 0)


class FakeRange(RangeSensor):
    """Reads the distance that a test has set."""

    def __init__(self, distance: float) -> None:
        super().__init__("nose", min_range=0.02, max_range=4.3, cone=0.5)
        self.distance = distance

    def _newest(self) -> Range:
        return Range(self.distance, 0.0, 0)
