"""The driver of a row of digital line sensors, each on a GPIO of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from threading import Lock
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import translate_pin_errors
from robotcore.description import RobotDescription
from robotcore.errors import Mistake
from robotcore.hal.clock import Clock
from robotcore.hal.device_test import IN_OTHER_ORDER, INVERTED
from robotcore.hal.sampling import SampleCache
from robotcore.hardware import Connection, DeviceContext, DeviceDriver, Drivers
from robotcore.kinds.line_sensor import Darkness, LineSensor, LineSensorDescription
from robotcore.text import pluralize

SUPPLY = (
    "Supply the sensors with 3.3 V, because their outputs have the voltage of their supply. Turn the potentiometer of "
    "each until its light changes at the edge of the line."
)
"""The note that `robotcore wiring` prints for the sensors."""


def _require_distinct(gpios: tuple[int, ...]) -> tuple[int, ...]:
    doubles = sorted({number for number in gpios if gpios.count(number) > 1})
    if doubles:
        raise Mistake(f"GPIO {doubles[0]} occurs twice", "Name a GPIO for each sensor", kind="same-pin")
    return gpios


class PinLineSensor(LineSensor):
    """A row of digital sensors on GPIOs. Any thread may read it.

    An unplugged sensor cannot be distinguished from one over a white floor.

    lines: gpiozero's device of each GPIO, from left to right, which is active over a line.
    """

    def __init__(
        self, description: LineSensorDescription, clock: Clock, lines: Sequence[Any], opened: ExitStack
    ) -> None:
        super().__init__(description.name, **description.arguments())
        self._lines, self._opened = lines, opened
        self._newest_at = SampleCache(clock, self._take)
        self._lock = Lock()

    def _newest(self) -> Darkness:
        with self._lock:
            return self._newest_at()

    def _take(self, time: float, sequence: int) -> Darkness:
        return Darkness(tuple(float(line.is_active) for line in self._lines), time, sequence)

    def _release(self) -> None:
        self._opened.close()


class PinLineSensorDriver(DeviceDriver):
    """Opens rows of line sensors with a digital output each, such as modules with a TCRT5000 and a comparator."""

    name = "line-sensors"
    summary = "a row of digital line sensors, each on a GPIO"
    described = LineSensorDescription
    modules = ("gpiozero",)
    connector = "GPIO"
    remedy = "pip install 'robotcore[pi]'"
    supply = ("3.3 V", "ground")
    aliases = ("tcrt5000", "line-follower")

    gpios: Annotated[tuple[Gpio, ...], AfterValidator(_require_distinct), Field(description="a list of GPIOs")]
    """The GPIO of each sensor, from left to right."""
    active_high: bool = True
    """Whether an output is high over a black line."""

    def connections(self) -> Sequence[Connection]:
        return [gpio(f"gpios[#{number}]", each) for number, each in enumerate(self.gpios, start=1)]

    def check(self, description: LineSensorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if len(self.gpios) != description.count:
            number = pluralize(len(self.gpios), "GPIO")
            problem = f"gpios has {number}, and {description.name} has count = {description.count}"
            raise Mistake(problem, "Name a GPIO for each sensor", kind="wrong-count")

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        if mistake == INVERTED:
            return {"active_high": not self.active_high}
        return {"gpios": [self.gpios[number] for number in observed]} if mistake == IN_OTHER_ORDER else None

    def notes(self, description: LineSensorDescription) -> Sequence[str]:
        return (SUPPLY,)

    def open(self, description: LineSensorDescription, context: DeviceContext) -> LineSensor:
        from gpiozero import InputDevice

        with ExitStack() as opened:
            lines = []
            for number in self.gpios:
                with translate_pin_errors(description.name, (number,)):
                    line = InputDevice(number, pull_up=not self.active_high, pin_factory=context.pins)
                    lines.append(opened.enter_context(line))
            return PinLineSensor(description, context.clock, lines, opened.pop_all())
