"""An encoder on mock pins that a test turns edge by edge."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device, Encoder
from robotcore.hardware import Host, bind_devices, open_devices
from tests.drivers.raspberrypi.motors.rig import rover

TURN = 24
"""The described counts in a turn."""


class Wires:
    """The left encoder of a rover, open on mock pins."""

    def __init__(self, section: Mapping[str, Any], pins: Any = None, opened: dict[str, Device] | None = None) -> None:
        self.pins = pins or MockFactory(pin_class=MockPWMPin)
        self.clock = SteppedClock(50.0, lambda steps: None)
        self.opened = {} if opened is None else opened
        robot = rover({"left_encoder": section}, TURN)
        (self.binding,) = bind_devices(robot, "raspberrypi", ["left_encoder"])
        open_devices([self.binding], Host(robot, self.clock, self.pins, self.opened), self.opened)

    @property
    def encoder(self) -> Encoder:
        encoder = self.opened["left_encoder"]
        assert isinstance(encoder, Encoder)
        return encoder

    def angle(self) -> float:
        """Return the angle at the next instant, in rad."""
        self.clock.sleep_until(self.clock.now() + self.clock.step)
        return self.encoder.read().angle

    def set(self, number: int, is_high: int) -> None:
        pin = self.pins.pin(number)
        pin.drive_high() if is_high else pin.drive_low()
