"""The two pins of an ultrasonic module."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from drivers.raspberrypi.claiming import claiming
from drivers.raspberrypi.edges import hear_no_more

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
            with claiming(device, (trigger,)):
                self._trigger = undo.enter_context(OutputDevice(trigger, pin_factory=pins))
            with claiming(device, (echo,)):
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
            hear_no_more(self._echo.pin)
