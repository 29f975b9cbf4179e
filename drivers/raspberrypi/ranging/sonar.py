"""An ultrasonic range sensor: its pins, its cycles, and the schedule of the triggers of several modules."""

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
from robotcore.hardware.polled import RangeSampler


class Sonar(RangeSensor):
    """Triggers the module whenever it is its turn; the falling edge of its echo tells the distance."""

    def __init__(
        self,
        description: RangeSensorDescription,
        findings: RangeSampler,
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
        self._findings, self._timer, self._pins = findings, timer, pins
        self._clock, self._scheduler, self._cycle_s = clock, scheduler, cycle_s
        self._stopping = ExitStack()

    def start(self, first_cycles: int) -> None:
        """Hear something within so many cycles, then go on beside the app; raises DeviceError."""
        self._stopping.callback(self._pins.close)
        self._stopping.callback(self._timer.stop)
        self._pins.listen(self._timer.edge)
        self._scheduler.pause()
        for _ in range(first_cycles):
            self._cycle()
            self._timer.ended.wait(self._cycle_s)
            if self._findings.has_result:
                break
        self._newest()
        self._stopping.callback(self._scheduler.leave, self._cycle)
        self._scheduler.join(self._cycle, self._cycle_s)

    def _cycle(self) -> None:
        try:
            self._trigger()
        except Exception as error:  # noqa: BLE001  told by whoever reads
            self._timer.fail(error)

    def _trigger(self) -> None:
        if self._pins.is_high:
            self._timer.wait()
            return
        self._timer.begin(self._clock.now(), self._pins.ticks())
        self._pins.trigger()

    def _newest(self) -> Range:
        return self._findings.newest.get()

    def _release(self) -> None:
        self._stopping.close()


TRIGGER_S = 10e-6
"""How long the trigger is high at least. Source: HC-SR04 data sheet, ElecFreaks."""


class EchoPins:
    """A trigger and an echo, on gpiozero's pins."""

    def __init__(self, device: str, trigger: int, echo: int, pins: Any) -> None:
        """Claim both; raises DeviceError."""
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
        """Whether the echo is high now."""
        return bool(self._echo.is_active)

    def ticks(self) -> Any:
        """Return the time as edges have it."""
        return self._factory.ticks()

    def listen(self, edge: Callable[[Any, bool], None]) -> None:
        """Call with the ticks of every edge of the echo, and whether it is high then; pins keep no method alive."""
        self._echo.pin.when_changed = edge

    def trigger(self) -> None:
        """Let the module send its burst."""
        self._trigger.on()
        self._never.wait(TRIGGER_S)
        self._trigger.off()

    def close(self) -> None:
        """Hear no edge any more, and let both go."""
        with self._undo:
            stop_edge_detection(self._echo.pin)


Cycle = Callable[[], object]
"""Triggers one module."""


class TriggerScheduler:
    """Lets each module do its cycle when it is its turn, the next one a period later.

    The period is the longest that any of them asks for. Whoever opens or closes a module may call; others wait.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._modules: list[tuple[Cycle, float]] = []
        self._polling: PeriodicTask | None = None
        self._at = 0

    def pause(self) -> None:
        """Let nobody have a turn until the next module joins or leaves: one that is being opened is to hear itself."""
        if self._polling:
            self._polling.stop()
            self._polling = None

    def join(self, cycle: Cycle, period: float) -> None:
        """Give a module its turn, from now on."""
        self.pause()
        self._modules.append((cycle, period))
        self._go_on()

    def leave(self, cycle: Cycle) -> None:
        """Give a module no turn any more; the one that it is having ends first."""
        self.pause()
        self._modules = [each for each in self._modules if each[0] != cycle]
        self._go_on()

    def close(self) -> None:
        """End all turns."""
        self.pause()

    def _go_on(self) -> None:
        if self._modules:
            period = max(period for _, period in self._modules)
            self._polling = self._clock.every(period, self._take, "ultrasonic")

    def _take(self) -> None:
        self._at = (self._at + 1) % len(self._modules)
        cycle, _ = self._modules[self._at]
        cycle()
