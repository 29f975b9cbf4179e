"""The drivers of switches on GPIOs: of bumpers (`Switch`) and of buttons (`PushButton`)."""

from __future__ import annotations

from collections.abc import Sequence
from threading import Lock
from typing import Any

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import translate_pin_errors
from robotcore.hal.device import Sensor
from robotcore.hal.kind import build_sensor, load_kind
from robotcore.hal.sampling import SampleCache
from robotcore.hardware import Connection, DeviceContext, DeviceDriver
from robotcore.kinds.bumper import BumperDescription
from robotcore.kinds.button import ButtonDescription

WIRING_NOTE = "Connect the switch between the GPIO and ground, without a resistor: the Pi pulls the pin up."


class ContactDriver(DeviceDriver):
    """The base class of the drivers of switches on GPIOs. Any thread may read their sensors.

    An unplugged switch cannot be distinguished from one that is not pressed.
    """

    modules = ("gpiozero",)
    connector = "GPIO"
    remedy = "pip install 'robotcore[pi]'"
    supply = ("ground",)

    gpio: Gpio
    """The GPIO that the pressed switch connects to ground."""

    def connections(self) -> Sequence[Connection]:
        return (gpio("gpio", self.gpio),)

    def notes(self, description: Any) -> Sequence[str]:
        return (WIRING_NOTE,)

    def open(self, description: Any, context: DeviceContext) -> Sensor[Any]:
        from gpiozero import InputDevice

        with translate_pin_errors(description.name, (self.gpio,)):
            line = InputDevice(self.gpio, pull_up=True, pin_factory=context.pins)
        sample, lock = load_kind(description.kind).sample, Lock()
        newest = SampleCache(context.clock, lambda time, sequence: sample(bool(line.is_active), time, sequence))

        def read() -> Any:
            with lock:
                return newest()

        return build_sensor(description, read, line.close)


class Switch(ContactDriver):
    """Opens bumpers whose switch is on a GPIO."""

    name = "switch"
    summary = "a bumper's switch on a GPIO"
    described = BumperDescription
    aliases = ("micro-switch",)


class PushButton(ContactDriver):
    """Opens buttons on a GPIO."""

    name = "button"
    summary = "a button on a GPIO"
    described = ButtonDescription
    aliases = ("push-button",)
