"""HC-SR04 and its likes: ultrasonic modules that answer a trigger with a pulse as long as the echo took."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.ranging.echo_timer import EchoTimer
from drivers.raspberrypi.ranging.sonar import EchoPins, Sonar, TriggerScheduler
from robotcore.description import RangeSensorDescription, RobotDescription, StrictModel
from robotcore.hal.devices import RangeSensor
from robotcore.hardware import Connection, DeviceDriver, Host
from robotcore.hardware.polled import RangeSampler, require_timely

REACH_M = 4.0
"""Source: HC-SR04 data sheet, ElecFreaks."""

_VERDICT_CYCLES = 5
"""What one echo-free cycle may last at the opening: copies end it after 200 ms."""

LEVEL = (
    "The echo is 5 V, and GPIO {echo} takes 3.3 V: 1 kΩ from the echo to GPIO {echo}, and 2 kΩ from there to ground, "
    "make 3.3 V of it. Without them the board may be destroyed. A module that runs on 3.3 V (HC-SR04P, RCWL-1601) is "
    "fed from a pad of 3.3 V and needs none."
)
"""What whoever connects one must know."""


class UltrasonicSettings(StrictModel):
    """Its two pins, how often it is triggered, and how it is judged.

    So many ``echo_free_cycles`` in a row vouch for nothing in range; 0: only an echo from beyond does.
    """

    trigger: Gpio
    echo: Gpio
    cycle_s: Annotated[float, Field(ge=0.05, le=1)] = 0.06
    air_temperature_c: Annotated[float, Field(ge=-40, le=60)] = 20.0
    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] = 10


class Ultrasonic(DeviceDriver[RangeSensorDescription, UltrasonicSettings]):
    """Times the echo of an HC-SR04 by the time stamps of its edges, where the pin factory has them by the kernel's.

    A sample's time is when its trigger was given. A lost echo is no new sample; `inf` is an echo from beyond
    ``max_range_m``, or a row of cycles without one.

    Several modules take turns, each a ``cycle_s``: one that heard another's burst would tell a distance that is too
    short.
    """

    name = "hc-sr04"
    summary = "HC-SR04 and its likes: ultrasonic, on a trigger and an echo pin"
    described = RangeSensorDescription
    settings = UltrasonicSettings
    aliases = ("ultrasonic", "sonar", "rcwl-1601")
    modules = ("gpiozero",)
    supply = ("5 V", "ground")
    remedy = "On the Pi: pip install 'robotcore[pi]'"

    def check(self, description: RangeSensorDescription, settings: UltrasonicSettings, robot: RobotDescription) -> None:
        if description.max_range_m > REACH_M:
            raise ValueError(
                f"an HC-SR04 hears as far as {REACH_M:g} m, and max_range_m is {description.max_range_m:g}; lower it"
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
        findings = RangeSampler(description, settings.echo_free_cycles)
        speed = speed_of_sound(settings.air_temperature_c)
        timer = EchoTimer(description.name, findings, speed, settings.cycle_s, host.pins.ticks_diff)
        pins = EchoPins(description.name, settings.trigger, settings.echo, host.pins)
        with ExitStack() as undo:
            scheduler = host.shared.take(TriggerScheduler, None, lambda: TriggerScheduler(host.clock))
            sonar = Sonar(description, findings, timer, pins, host.clock, scheduler, settings.cycle_s)
            undo.callback(sonar.close)
            sonar.start(_VERDICT_CYCLES * max(settings.echo_free_cycles, 10))
            undo.pop_all()
        return sonar


def speed_of_sound(temperature_c: float) -> float:
    """Return the speed of sound in dry air, in m/s; 0.6 m/s more for each degree.

    The square root of the absolute temperature, through 331.45 m/s at 0 °C. Source: G. S. K. Wong, Speed of sound in
    standard air, J. Acoust. Soc. Am. 79 (1986), 1359. Humid air is up to 0.4 % faster.

    >>> round(speed_of_sound(20.0), 1)
    343.4
    """
    return 331.45 * math.sqrt(1 + temperature_c / 273.15)
