"""The driver of a bumper's switch on a GPIO."""

from __future__ import annotations

from collections.abc import Sequence
from threading import Lock
from typing import Any

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import translate_pin_errors
from robotcore.hal.clock import Clock
from robotcore.hal.sampling import SampleCache
from robotcore.hardware import Connection, DeviceDriver, Host
from robotcore.kinds.bumper import Bumper, BumperDescription, Touch

WIRES = "Connect the switch between the GPIO and ground, without a resistor: the Pi pulls the pin up."


class PinBumper(Bumper):
    """A switch on a GPIO. Any thread may read it.

    An unplugged switch cannot be distinguished from one that is not pressed.

    line: gpiozero's device of the GPIO, which is active while the switch is pressed.
    """

    def __init__(self, name: str, clock: Clock, line: Any) -> None:
        super().__init__(name)
        self._line = line
        self._newest_at = SampleCache(clock, self._take)
        self._lock = Lock()

    def _newest(self) -> Touch:
        with self._lock:
            return self._newest_at()

    def _take(self, time: float, sequence: int) -> Touch:
        return Touch(bool(self._line.is_active), time, sequence)

    def _release(self) -> None:
        self._line.close()


class Switch(DeviceDriver):
    """Opens bumpers whose switch is on a GPIO."""

    name = "switch"
    summary = "a bumper's switch on a GPIO"
    described = BumperDescription
    modules = ("gpiozero",)
    remedy = "pip install 'robotcore[pi]'"
    supply = ("ground",)
    aliases = ("button", "micro-switch")

    gpio: Gpio
    """The GPIO that the pressed switch connects to ground."""

    def connections(self) -> Sequence[Connection]:
        return (gpio("gpio", self.gpio),)

    def notes(self, description: BumperDescription) -> Sequence[str]:
        return (WIRES,)

    def open(self, description: BumperDescription, host: Host) -> Bumper:
        from gpiozero import InputDevice

        with translate_pin_errors(description.name, (self.gpio,)):
            line = InputDevice(self.gpio, pull_up=True, pin_factory=host.pins)
        return PinBumper(description.name, host.clock, line)
