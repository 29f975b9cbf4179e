"""A double of an HC-SR04 on mock pins, in simulated time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic, speed_of_sound
from drivers.raspberrypi.virtual.models import VirtualPins
from robotcore.description import load_robot
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hardware import DeviceContext
from robotcore.kinds.range_sensor import Range, RangeSensor, RangeSensorDescription

TRIGGER, ECHO = 16, 26
DELAY_S = 0.00045
"""The time from the trigger to the rise of the echo line, in seconds."""

Edges = Sequence[tuple[float, bool]]
"""The edges after a trigger: the time after the trigger in seconds, and the level."""


class FakeRange(RangeSensor):
    """A simulator's range sensor, which returns the distance that a test has set."""

    def __init__(self, distance: float) -> None:
        super().__init__("nose", min_range=0.02, max_range=4.3, cone=0.5)
        self.distance = distance

    def _newest(self) -> Range:
        return Range(self.distance, 0.0, 0)


@dataclass
class Module:
    """A module that sends ``pulses`` one after another, one for each trigger. It repeats the last pulse.

    is_immediate: whether edges come at once, because no simulated time passes during the opening of a sensor.
    """

    clock: Clock
    pins: VirtualPins
    pulses: list[Edges]
    triggers: list[float] = field(default_factory=list)
    is_immediate: bool = False
    gpios: tuple[int, int] = (TRIGGER, ECHO)

    def __post_init__(self) -> None:
        self.trigger, self.echo = map(self.pins.pin, self.gpios)
        self.trigger.on_change(self._on_trigger)

    def _on_trigger(self) -> None:
        if self.trigger.state:
            return
        now = self.clock.now()
        answer = self.pulses[min(len(self.triggers), len(self.pulses) - 1)]
        self.triggers.append(now)
        for after, level in answer:
            ticks = self.pins.ticks() + after
            if self.is_immediate:
                self.echo.drive(level, ticks)
            else:
                self.clock.call_at(now + after, partial(self.echo.drive, level, ticks))


def pulse(seconds: float) -> Edges:
    return (DELAY_S, True), (DELAY_S + seconds, False)


def build_echo(metres: float, temperature_c: float = 20.0) -> Edges:
    return pulse(2 * metres / speed_of_sound(temperature_c))


NO_PULSE: Edges = ()
NO_ECHO: Edges = pulse(0.038)
"""The pulse of the module's time-out."""

NOSE = next(device for device in load_robot("rover").devices if isinstance(device, RangeSensorDescription))


@dataclass
class Bench:
    """A module at the robot's nose, the sensor that reads it, and their clock."""

    pulses: list[Edges]
    settings: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.clock = SteppedClock(10000, lambda _steps: None)
        self.pins = VirtualPins(self.clock)
        self.host = DeviceContext(load_robot("rover"), self.clock, self.pins)
        self.module = Module(self.clock, self.pins, self.pulses)

    def open(self, name: str = "nose", module: Module | None = None) -> RangeSensor:
        module = module or self.module
        trigger, echo = module.gpios
        driver = Ultrasonic(trigger=trigger, echo=echo, **self.settings)
        module.is_immediate = True
        sensor = driver.open(NOSE.model_copy(update={"name": name}), self.host)
        module.is_immediate = False
        return sensor

    def cycles(self, count: int = 1) -> None:
        """Let ``count`` cycles pass, and stop in the next cycle after its echo."""
        done = math.floor(self.clock.now() / 0.06 + 1e-6)
        self.clock.sleep_until((done + count) * 0.06 + 0.055)
