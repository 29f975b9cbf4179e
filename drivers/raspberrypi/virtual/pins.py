"""Virtual pins: gpiozero's mock pins in simulated time, with models of hardware on their other end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.hal.clock import Clock

PI_4B = "c03115"
"""The revision code of the board that is made believe.
Source: https://www.raspberrypi.com/documentation/computers/raspberry-pi.html#raspberry-pi-revision-codes."""


class VirtualPin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin that models listen to where the program sets it, and drive where the program listens.

    Its duty is cut to whole percent, as lgpio does it. It keeps no history.
    """

    _state: float

    def __init__(self, factory: Any, info: Any) -> None:
        self._listeners: list[Callable[[], object]] = []
        self._is_driven = False
        super().__init__(factory, info)

    def on_change(self, listener: Callable[[], object]) -> None:
        """Call whenever the pin's level or duty has changed."""
        self._listeners.append(listener)

    def drive(self, level: int, ticks: float | None = None) -> None:
        """Set the level, 0 or 1, from outside; an edge is told as of ``ticks``, by default of now."""
        self._is_driven = True
        if self._function == "input" and self._change_state(bool(level)):
            if ticks is not None:
                self._last_change = ticks
            if self._when_changed and self._edges in ("both", "rising" if level else "falling"):
                self._call_when_changed()

    def drive_high(self) -> None:
        """Pull up, where nothing drives the pin."""
        if not self._is_driven:
            super().drive_high()

    def drive_low(self) -> None:
        """Pull down, where nothing drives the pin."""
        if not self._is_driven:
            super().drive_low()

    def clear_states(self) -> None:
        """Begin at now."""
        self._last_change = self._factory.ticks()

    def _set_state(self, value: float) -> None:
        super()._set_state(int(value * 100) / 100)

    def _change_state(self, value: float) -> bool:
        if self._state == value:
            return False
        self._state = value
        self._last_change = self._factory.ticks()
        for listener in self._listeners:
            listener()
        return True


class VirtualPins(MockFactory):  # type: ignore[misc]  # gpiozero has no types
    """Makes virtual pins, one a GPIO; its ticks are simulated time in seconds.

    >>> from gpiozero import LED
    >>> from robotcore.hal.clock import SteppedClock
    >>> with VirtualPins(SteppedClock(20.0, lambda steps: None)) as pins, LED(17, pin_factory=pins) as led:
    ...     led.on()
    ...     pins.pin(17).state
    1.0
    """

    def __init__(self, clock: Clock) -> None:
        super().__init__(revision=PI_4B, pin_class=VirtualPin)
        self._clock = clock

    def ticks(self) -> float:
        """Return the time in seconds."""
        return self._clock.now()
