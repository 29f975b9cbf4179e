"""The drivers of lights on GPIOs: of one colour (`LedDriver`), and of red, green and blue (`RgbLedDriver`)."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any, ClassVar

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import PWM_HZ, open_output
from robotcore.description import RobotDescription
from robotcore.hal.device_test import IN_OTHER_ORDER, INVERTED
from robotcore.hardware import Connection, DeviceContext, DeviceDriver, Drivers
from robotcore.kinds.led import Brightness, Led, LedDescription

RESISTOR = (
    "Put a resistor of 330 Ω in series with each LED, because a GPIO gives at most 16 mA. Connect a brighter light "
    "through a transistor."
)
"""The note that `robotcore wiring` prints for each light."""


class PinLight(Led):
    """A light on GPIOs, dimmed by the duty of its pins. A closed light is off.

    lines: gpiozero's device of each GPIO: of red, green and blue, or of the only colour.
    """

    def __init__(self, description: LedDescription, lines: Sequence[Any], opened: ExitStack) -> None:
        super().__init__(description.name, is_rgb=description.is_rgb)
        self._lines, self._opened = lines, opened

    def _apply(self, command: Brightness) -> None:
        for line, value in zip(self._lines, command if self.is_rgb else [max(command)], strict=True):
            line.value = value

    def _release(self) -> None:
        self._opened.close()


class LightDriver(DeviceDriver):
    """The base class of the drivers of lights on GPIOs."""

    described = LedDescription
    modules = ("gpiozero",)
    connector = "GPIO"
    remedy = "pip install 'robotcore[pi]'"
    is_rgb: ClassVar[bool]

    active_high: bool = True
    """Whether a high pin switches the light on. It is false for a light between the pin and 3.3 V."""

    @property
    @abstractmethod
    def gpios(self) -> Sequence[int]:
        """The GPIO of each colour."""

    def check(self, description: LedDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if description.is_rgb is not self.is_rgb:
            other = "led" if self.is_rgb else "rgb-led"
            raise ValueError(
                f"{self.name!r} is the driver of a light with is_rgb = {str(self.is_rgb).lower()}, and "
                f"{description.name} has is_rgb = {str(description.is_rgb).lower()}; change is_rgb, or use {other!r}"
            )

    def notes(self, description: LedDescription) -> Sequence[str]:
        return (RESISTOR,)

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"active_high": not self.active_high} if mistake == INVERTED else None

    def open(self, description: LedDescription, context: DeviceContext) -> Led:
        with ExitStack() as opened:
            name, pins, active_high = description.name, context.pins, self.active_high
            lines = [
                open_output(name, each, pins, opened, frequency_hz=PWM_HZ, active_high=active_high)
                for each in self.gpios
            ]
            return PinLight(description, lines, opened.pop_all())


class LedDriver(LightDriver):
    """Opens lights of one colour."""

    name = "led"
    summary = "a light of one colour on a GPIO"
    supply = ("ground",)
    is_rgb = False

    gpio: Gpio

    @property
    def gpios(self) -> Sequence[int]:
        return (self.gpio,)

    def connections(self) -> Sequence[Connection]:
        return (gpio("gpio", self.gpio),)


class RgbLedDriver(LightDriver):
    """Opens lights of red, green and blue."""

    name = "rgb-led"
    summary = "a light of red, green and blue on three GPIOs"
    supply = ("ground",)
    is_rgb = True

    red: Gpio
    green: Gpio
    blue: Gpio

    @property
    def gpios(self) -> Sequence[int]:
        return self.red, self.green, self.blue

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        if mistake != IN_OTHER_ORDER:
            return super().correct(mistake, observed)
        return dict(zip(("red", "green", "blue"), (self.gpios[number] for number in observed), strict=True))

    def connections(self) -> Sequence[Connection]:
        return gpio("red", self.red), gpio("green", self.green), gpio("blue", self.blue)
