"""Turns: one ultrasonic module is triggered at a time, so that none takes another's burst for its echo."""

from __future__ import annotations

from collections.abc import Callable

from robotcore.hal.clock import Clock, Polling

Cycle = Callable[[], object]
"""Triggers one module."""


class Turns:
    """Lets each module do its cycle when it is its turn, the next one a period later.

    The period is the longest that any of them asks for. Whoever opens or closes a module may call; others wait.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._modules: list[tuple[Cycle, float]] = []
        self._polling: Polling | None = None
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
