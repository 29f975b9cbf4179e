"""Advance the simulation in real time, or, if clients step it, as soon as all of them have requested a step."""

from __future__ import annotations

import threading

from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.coppeliasim.scene.simulator import Simulator, State

HURRY_S = 0.002
"""The duration of each of the last steps before a stop, in seconds. No client requests these steps."""

LATE_S = 0.25
"""The delay, in seconds, above which the pacer does not catch up."""


class Pacer:
    """A thread that performs the steps that no client requests. It runs while this context manager is open."""

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._clock = MonotonicClock()
        self._due: float | None = None
        self._is_closing = False
        self._thread = threading.Thread(target=self._run, name="pacer of a double", daemon=True)

    def __enter__(self) -> Pacer:
        self._thread.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        with self._simulator.lock:
            self._is_closing = True
            self._simulator.changed.notify_all()
        self._thread.join()

    def _run(self) -> None:
        with self._simulator.lock:
            while not self._is_closing:
                wait = self._compute_wait_s()
                if wait is None or wait > 0:
                    self._simulator.changed.wait(wait)
                else:
                    self._simulator.advance()

    def _compute_wait_s(self) -> float | None:
        """Return the time until the next step in seconds. None means: wait until the simulation changes."""
        simulator = self._simulator
        if not simulator.state.is_advancing or simulator.is_held:
            self._due = None
            return None
        if simulator.is_stepped:
            return 0.0
        return self._until_due(self._period(simulator))

    def _until_due(self, period: float) -> float:
        now = self._clock.now()
        if self._due is None or now > self._due + LATE_S:
            self._due = now + period
        elif now >= self._due:
            self._due += period
            return 0.0
        return self._due - now

    @staticmethod
    def _period(simulator: Simulator) -> float:
        is_ending = simulator.state in {State.ABOUT_TO_STOP, State.LAST_BEFORE_STOP}
        return HURRY_S if is_ending else simulator.time_step
