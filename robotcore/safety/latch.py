"""The latch and the emergency stop. A tripped latch ends the run, even if the app catches the exception."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from threading import RLock
from typing import NoReturn

from robotcore.errors import EmergencyStopError, RobotcoreError, SafetyStop
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.thread_reserve import Reserve
from robotcore.safety.velocity_limits import STOPPED, Intervention
from robotcore.threads import is_out_of_memory

__all__ = ["EmergencyStop"]


class Latch:
    """Stores the first error of a run, and stops the motors. Any thread may trip the latch.

    reserve: the reserved memory for the stops.

    >>> latch = Latch()
    >>> latch.add_stop(lambda: print("the motors are stopped"))
    >>> latch.set(EmergencyStopError("the button was pressed"))
    the motors are stopped
    >>> latch
    Latch(error='e-stop: the button was pressed')
    >>> latch.check()
    Traceback (most recent call last):
    robotcore.errors.EmergencyStopError: e-stop: the button was pressed
    """

    def __init__(self, reserve: Reserve | None = None) -> None:
        self.error: RobotcoreError | None = None
        """The first error. None until the latch trips."""
        self.last_velocities = STOPPED
        """The last wheel velocities before the latch tripped, in rad/s."""
        self.unreported_interventions: Sequence[Intervention] = ()
        """The interventions of the deadman that no tick had recorded when the latch tripped."""
        self._lock = RLock()
        self._reserve = reserve or Reserve(MonotonicClock())
        self._stops: list[Callable[[], object]] = []

    def __repr__(self) -> str:
        return f"Latch(error={str(self.error)!r})" if self.error else "Latch()"

    @property
    def cause(self) -> str:
        """The cause of the latch's intervention in the trace.

        It is ``watchdog`` if the error is that of a device or a backend, because the watchdog has reported it.
        """
        return self.error.cause if isinstance(self.error, SafetyStop) else "watchdog"

    def interventions(self, now: float) -> tuple[Intervention, ...]:
        """Return the interventions for the trace: the unreported stops by the deadman, and the stop by the latch."""
        return (*self.unreported_interventions, Intervention(now, self.cause, self.last_velocities, STOPPED))

    def add_stop(self, stop: Callable[[], object]) -> None:
        """Add a function that stops motors. The latch calls it when it trips, in the thread that trips it.

        The latch calls several functions in the order in which they were added.
        """
        self._stops.append(stop)

    def set(self, error: RobotcoreError) -> None:
        """Trip the latch: store the error if it is the first one, and call every function that stops motors.

        An exception of a stop is ignored, because closing the robot repeats the stop.
        """
        with self._lock:
            self.error = self.error or error
        self._reserve.retry_on_memory_error(self._call_stops)

    def _call_stops(self) -> None:
        # Each function is called once. If it runs out of memory twice, the next `set` calls it again.
        for call in tuple(self._stops):
            try:
                self._reserve.retry_on_memory_error(call)
            except Exception as failure:  # noqa: BLE001  one failure must not prevent the other stops
                if is_out_of_memory(failure):
                    continue
            with suppress(ValueError):  # another thread has called it too
                self._stops.remove(call)

    def trip(self, error: RobotcoreError) -> NoReturn:
        """Trip the latch, and raise its first error."""
        self.set(error)
        raise self.error or error

    def check(self) -> None:
        """Raise the stored error if the latch has tripped."""
        if self.error:
            raise self.error


class EmergencyStop:
    """Stops every motor until the end of the run, from any thread. An app cannot undo the stop.

    >>> from robotcore.safety.latch import Latch
    >>> latch = Latch()
    >>> EmergencyStop(latch).press("the button on the bench was pressed")
    >>> str(latch.error)
    'e-stop: the button on the bench was pressed'
    """

    def __init__(self, latch: Latch) -> None:
        self._latch = latch

    def press(self, reason: str) -> None:
        """Stop every motor at once, and end the run. The result has ``reason``."""
        self._latch.set(EmergencyStopError(reason))
