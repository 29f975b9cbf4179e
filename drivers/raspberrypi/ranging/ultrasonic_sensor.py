"""An ultrasonic range sensor, its pins, and the scheduler that triggers several modules in turn."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from drivers.raspberrypi.pins import stop_edge_detection, translate_pin_errors
from drivers.raspberrypi.ranging.echo_timer import EchoTimer
from robotcore.description import RangeSensorDescription
from robotcore.hal.clock import Clock, PeriodicTask
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hardware.polled_samples import RangeSampler


class Sonar(RangeSensor):
    """An ultrasonic sensor. The scheduler triggers its module, and the length of the echo pulse gives the distance."""

    def __init__(
        self,
        description: RangeSensorDescription,
        sampler: RangeSampler,
        timer: EchoTimer,
        pins: EchoPins,
        clock: Clock,
        scheduler: TriggerScheduler,
        cycle_s: float,
    ) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._sampler, self._timer, self._pins = sampler, timer, pins
        self._clock, self._scheduler, self._cycle_s = clock, scheduler, cycle_s
        self._stopping = ExitStack()

    def start(self, first_cycles: int) -> None:
        """Take the first sample, and then measure in the background.

        Raises DeviceError if there is no sample within ``first_cycles`` cycles.
        """
        self._stopping.callback(self._pins.close)
        self._stopping.callback(self._timer.stop)
        self._pins.detect_edges(self._timer.on_edge)
        self._scheduler.pause()
        for _ in range(first_cycles):
            self._cycle()
            self._timer.ended.wait(self._cycle_s)
            if self._sampler.has_result:
                break
        self._newest()
        self._stopping.callback(self._scheduler.leave, self._cycle)
        self._scheduler.join(self._cycle, self._cycle_s)

    def _cycle(self) -> None:
        try:
            self._trigger()
        except Exception as error:  # noqa: BLE001  `read` raises it
            self._timer.fail(error)

    def _trigger(self) -> None:
        if self._pins.is_high:
            self._timer.skip_cycle()
            return
        self._timer.begin(self._clock.now(), self._pins.ticks())
        self._pins.trigger()

    def _newest(self) -> Range:
        return self._sampler.newest.get()

    def _release(self) -> None:
        self._stopping.close()


TRIGGER_S = 10e-6
"""The length of the trigger pulse in seconds, the shortest that the data sheet allows. Source: HC-SR04 data sheet,
ElecFreaks."""


class EchoPins:
    """The trigger pin and the echo pin of a module."""

    def __init__(self, device: str, trigger: int, echo: int, pins: Any) -> None:
        """Claim both pins; raises DeviceError.

        device: the sensor's name, for errors.
        trigger: the GPIO of the trigger.
        echo: the GPIO of the echo.
        pins: gpiozero's pin factory.
        """
        from gpiozero import InputDevice, OutputDevice

        self._factory = pins
        self._never = threading.Event()
        with ExitStack() as undo:
            with translate_pin_errors(device, (trigger,)):
                self._trigger = undo.enter_context(OutputDevice(trigger, pin_factory=pins))
            with translate_pin_errors(device, (echo,)):
                self._echo = undo.enter_context(InputDevice(echo, pin_factory=pins))
            self._undo = undo.pop_all()

    @property
    def is_high(self) -> bool:
        """Whether the echo line is high now."""
        return bool(self._echo.is_active)

    def ticks(self) -> Any:
        """Return the current time in ticks of the pin factory."""
        return self._factory.ticks()

    def detect_edges(self, on_edge: Callable[[Any, bool], None]) -> None:
        """Call ``on_edge`` with the ticks and the level of every edge of the echo line, until `close`.

        The caller must keep the object of the method ``on_edge`` alive, because gpiozero has only a weak reference.
        """
        self._echo.pin.when_changed = on_edge

    def trigger(self) -> None:
        """Send a trigger pulse."""
        self._trigger.on()
        self._never.wait(TRIGGER_S)
        self._trigger.off()

    def close(self) -> None:
        """Stop edge detection, and close both pins."""
        with self._undo:
            stop_edge_detection(self._echo.pin)


Cycle = Callable[[], object]
"""A function that triggers one module."""


class TriggerScheduler:
    """Triggers several modules in turn, so that a module does not receive the burst of another module.

    It triggers one module in each period, which is the longest period of all modules. The methods are not thread-safe.
    They are called only when a robot opens or closes modules.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._modules: list[tuple[Cycle, float]] = []
        self._polling: PeriodicTask | None = None
        self._at = 0

    def pause(self) -> None:
        """Stop all triggers until `join`, so that a module receives only its own echo during its opening."""
        if self._polling:
            self._polling.stop()
            self._polling = None

    def join(self, cycle: Cycle, period: float) -> None:
        """Add a module, and start or resume triggering.

        cycle: triggers the module.
        period: the module's shortest time between two triggers, in seconds.
        """
        self.pause()
        self._modules.append((cycle, period))
        self._resume()

    def leave(self, cycle: Cycle) -> None:
        """Remove the module that ``cycle`` triggers. The other modules continue."""
        self.pause()
        self._modules = [each for each in self._modules if each[0] != cycle]
        self._resume()

    def close(self) -> None:
        """Stop triggering."""
        self.pause()

    def _resume(self) -> None:
        if self._modules:
            period = max(period for _, period in self._modules)
            self._polling = self._clock.every(period, self._run_next, "ultrasonic")

    def _run_next(self) -> None:
        self._at = (self._at + 1) % len(self._modules)
        cycle, _ = self._modules[self._at]
        cycle()
