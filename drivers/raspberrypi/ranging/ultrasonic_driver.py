"""The driver of the HC-SR04 and compatible ultrasonic modules.

Such a module answers a trigger with a pulse whose length is the time until the echo returns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.ranging.echo_timer import EchoTimer
from drivers.raspberrypi.ranging.ultrasonic_sensor import EchoPins, Sonar, TriggerScheduler
from robotcore.description import RangeSensorDescription, RobotDescription, StrictModel
from robotcore.hal.devices import RangeSensor
from robotcore.hardware import Connection, DeviceDriver, Host
from robotcore.hardware.polled_samples import RangeSampler, require_timely

REACH_M = 4.0
"""The longest distance that the module measures, in metres. Source: HC-SR04 data sheet, ElecFreaks."""

_CYCLES_WITHOUT_ECHO = 5
"""The maximum number of cycles until a module reports that there was no echo. Some copies take 200 ms. So opening waits
for up to ``echo_free_cycles`` times this many cycles."""

LEVEL = (
    "The echo has 5 V, and GPIO {echo} takes only 3.3 V. Connect 1 kΩ from the echo to GPIO {echo}, and 2 kΩ from "
    "there to ground; without them the board may be destroyed. A module for 3.3 V (HC-SR04P, RCWL-1601) needs no "
    "resistors: supply it from a pad of 3.3 V."
)
"""The note that `robotcore wiring` prints for an ultrasonic module."""


class UltrasonicSettings(StrictModel):
    """The settings of an ultrasonic module."""

    trigger: Gpio
    echo: Gpio

    cycle_s: Annotated[float, Field(ge=0.05, le=1)] = 0.06
    """The time between two triggers, in seconds."""

    air_temperature_c: Annotated[float, Field(ge=-40, le=60)] = 20.0
    """The air temperature in °C, which determines the speed of sound."""

    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] = 10
    """After this many cycles in a row without an echo, the sample is `inf`. With 0, a cycle without an echo never
    makes a sample."""


class Ultrasonic(DeviceDriver[RangeSensorDescription, UltrasonicSettings]):
    """Opens ultrasonic modules. The kernel's timestamps of the echo line's edges give the length of a pulse.

    The time of a sample is the time of its trigger. A distance is `inf` after an echo from beyond ``max_range_m``, or
    after ``echo_free_cycles`` cycles without an echo. A single cycle without an echo makes no sample, because the echo
    may be lost.

    Several modules are triggered in turn. Otherwise a module might receive the burst of another module, and measure too
    short a distance.
    """

    name = "hc-sr04"
    summary = "HC-SR04 and compatible modules: ultrasonic, on a trigger and an echo pin"
    described = RangeSensorDescription
    settings = UltrasonicSettings
    aliases = ("ultrasonic", "sonar", "rcwl-1601")
    modules = ("gpiozero",)
    supply = ("5 V", "ground")
    remedy = "On the Pi: pip install 'robotcore[pi]'"

    def check(self, description: RangeSensorDescription, settings: UltrasonicSettings, robot: RobotDescription) -> None:
        if description.max_range_m > REACH_M:
            raise ValueError(
                f"the range of an HC-SR04 is {REACH_M:g} m, but max_range_m is {description.max_range_m:g}; lower it"
            )

    def check_beside(
        self,
        description: RangeSensorDescription,
        settings: UltrasonicSettings,
        robot: RobotDescription,
        drivers: Mapping[str, DeviceDriver[Any, Any]],
    ) -> None:
        modules = sum(isinstance(driver, Ultrasonic) for driver in drivers.values())
        require_timely(settings.echo_free_cycles, settings.cycle_s, robot, modules)

    def connections(self, settings: UltrasonicSettings) -> Sequence[Connection]:
        return gpio("trigger", settings.trigger), gpio("echo", settings.echo)

    def notes(self, description: RangeSensorDescription, settings: UltrasonicSettings) -> Sequence[str]:
        return (LEVEL.format(echo=settings.echo),)

    def open(self, description: RangeSensorDescription, settings: UltrasonicSettings, host: Host) -> RangeSensor:
        sampler = RangeSampler(description, settings.echo_free_cycles)
        speed = speed_of_sound(settings.air_temperature_c)
        timer = EchoTimer(description.name, sampler, speed, settings.cycle_s, host.pins.ticks_diff)
        pins = EchoPins(description.name, settings.trigger, settings.echo, host.pins)
        with ExitStack() as undo:
            scheduler = host.shared.take(TriggerScheduler, None, lambda: TriggerScheduler(host.clock))
            sonar = Sonar(description, sampler, timer, pins, host.clock, scheduler, settings.cycle_s)
            undo.callback(sonar.close)
            sonar.start(_CYCLES_WITHOUT_ECHO * max(settings.echo_free_cycles, 10))
            undo.pop_all()
        return sonar


def speed_of_sound(temperature_c: float) -> float:
    """Return the speed of sound in dry air, in m/s. In humid air the speed is up to 0.4 % higher.

    The speed is 331.45 m/s at 0 °C, and proportional to the square root of the absolute temperature. Source: G. S. K.
    Wong, Speed of sound in standard air, J. Acoust. Soc. Am. 79 (1986), 1359.

    >>> round(speed_of_sound(20.0), 1)
    343.4
    """
    return 331.45 * math.sqrt(1 + temperature_c / 273.15)
