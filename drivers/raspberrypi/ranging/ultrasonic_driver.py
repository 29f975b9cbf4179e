"""The driver of the HC-SR04 and compatible ultrasonic modules.

Such a module answers a trigger with a pulse whose length is the time until the echo returns.
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Sequence
from typing import Annotated

from pydantic import Field

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import stop_edge_detection, translate_pin_errors
from drivers.raspberrypi.ranging.echo_timer import EchoTimer
from robotcore.description import RobotDescription
from robotcore.hal.clock import Clock, PeriodicTask
from robotcore.hardware import Connection, DeviceContext, DeviceDriver, Drivers, PolledRangeSensor
from robotcore.hardware.polled_samples import RangeSampler, require_timely
from robotcore.kinds.range_sensor import RangeSensor, RangeSensorDescription

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


class Ultrasonic(DeviceDriver):
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
    aliases = ("ultrasonic", "sonar", "rcwl-1601")
    modules = ("gpiozero",)
    connector = "GPIO"
    supply = ("5 V", "ground")
    remedy = "On the Pi: pip install 'robotcore[pi]'"

    trigger: Gpio
    echo: Gpio

    cycle_s: Annotated[float, Field(ge=0.05, le=1)] = 0.06
    """The time between two triggers, in seconds."""

    air_temperature_c: Annotated[float, Field(ge=-40, le=60)] = 20.0
    """The air temperature in °C, which determines the speed of sound."""

    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] = 10
    """After this many cycles in a row without an echo, the sample is `inf`. With 0, a cycle without an echo never
    makes a sample."""

    def check(self, description: RangeSensorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if description.max_range_m > REACH_M:
            raise ValueError(
                f"the range of an HC-SR04 is {REACH_M:g} m, but max_range_m is {description.max_range_m:g}; lower it"
            )
        modules = sum(isinstance(driver, Ultrasonic) for driver in drivers.values())
        require_timely(self.echo_free_cycles, self.cycle_s, robot, modules)

    def connections(self) -> Sequence[Connection]:
        return gpio("trigger", self.trigger), gpio("echo", self.echo)

    def notes(self, description: RangeSensorDescription) -> Sequence[str]:
        return (LEVEL.format(echo=self.echo),)

    def open(self, description: RangeSensorDescription, context: DeviceContext) -> RangeSensor:
        sonar = Sonar(description, self, context)
        sonar.open()
        return sonar


def speed_of_sound(temperature_c: float) -> float:
    """Return the speed of sound in dry air, in m/s. In humid air the speed is up to 0.4 % higher.

    The speed is 331.45 m/s at 0 °C, and proportional to the square root of the absolute temperature. Source: G. S. K.
    Wong, Speed of sound in standard air, J. Acoust. Soc. Am. 79 (1986), 1359.

    >>> round(speed_of_sound(20.0), 1)
    343.4
    """
    return 331.45 * math.sqrt(1 + temperature_c / 273.15)


TRIGGER_S = 10e-6
"""The length of the trigger pulse in seconds, the shortest that the data sheet allows. Source: HC-SR04 data sheet,
ElecFreaks."""


class Sonar(PolledRangeSensor):
    """An ultrasonic sensor. The scheduler triggers its module, and the length of the echo pulse gives the distance."""

    def __init__(self, description: RangeSensorDescription, settings: Ultrasonic, context: DeviceContext) -> None:
        super().__init__(description, RangeSampler(description, settings.echo_free_cycles))
        self._settings, self._host = settings, context
        speed = speed_of_sound(settings.air_temperature_c)
        self._timer = EchoTimer(description.name, self._sampler, speed, settings.cycle_s, context.pins.ticks_diff)

    def _start(self) -> None:
        from gpiozero import InputDevice, OutputDevice

        settings, host, opened = self._settings, self._host, self._opened
        with translate_pin_errors(self.name, (settings.trigger,)):
            self._trigger = opened.enter_context(OutputDevice(settings.trigger, pin_factory=host.pins))
        with translate_pin_errors(self.name, (settings.echo,)):
            self._echo = opened.enter_context(InputDevice(settings.echo, pin_factory=host.pins))
        opened.callback(stop_edge_detection, self._echo.pin)
        opened.callback(self._timer.stop)
        self._echo.pin.when_changed = self._timer.on_edge
        scheduler = host.shared.take(TriggerScheduler, None, lambda: TriggerScheduler(host.clock))
        scheduler.pause()
        cycles = _CYCLES_WITHOUT_ECHO * max(settings.echo_free_cycles, 10)
        self._take_first(self._cycle, lambda: self._timer.ended.wait(settings.cycle_s), cycles)
        opened.callback(scheduler.leave, self._cycle)
        scheduler.join(self._cycle, settings.cycle_s)

    def _cycle(self) -> None:
        try:
            self._send_trigger()
        except Exception as error:  # noqa: BLE001  `read` raises it
            self._timer.fail(error)

    def _send_trigger(self) -> None:
        if self._echo.is_active:
            self._timer.skip_cycle()
            return
        self._timer.begin(self._host.clock.now(), self._host.pins.ticks())
        self._trigger.on()
        threading.Event().wait(TRIGGER_S)
        self._trigger.off()


Cycle = Callable[[], object]
"""A function that triggers one module."""


class TriggerScheduler:
    """Triggers several modules in turn, so that a module does not receive the burst of another module.

    It triggers one module in each period, which is the longest period of all modules. The methods are not thread-safe.
    They are called only when a robot opens or closes modules.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._periods: dict[Cycle, float] = {}
        self._polling: PeriodicTask | None = None

    def pause(self) -> None:
        """Stop all triggers until `join`, so that a module receives only its own echo during its opening."""
        if self._polling:
            self._polling.stop()
            self._polling = None

    close = pause

    def join(self, cycle: Cycle, period: float) -> None:
        """Add a module, and start or resume triggering.

        cycle: triggers the module.
        period: the module's shortest time between two triggers, in seconds.
        """
        self.pause()
        self._periods[cycle] = period
        self._resume()

    def leave(self, cycle: Cycle) -> None:
        """Remove the module that ``cycle`` triggers. The other modules continue."""
        self.pause()
        del self._periods[cycle]
        self._resume()

    def _resume(self) -> None:
        if self._periods:
            self._turns = itertools.cycle(self._periods)
            self._polling = self._clock.call_every(max(self._periods.values()), self._run_next, "ultrasonic")

    def _run_next(self) -> None:
        cycle = next(self._turns)
        cycle()
