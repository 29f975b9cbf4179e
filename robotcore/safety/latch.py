"""The latch and the emergency stop: once tripped, the run ends, whatever the app catches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from threading import RLock
from typing import NoReturn

from robotcore.errors import EmergencyStopError, RobotcoreError, SafetyStop
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.reserve import Reserve
from robotcore.safety.rules import STOPPED, Intervention
from robotcore.threads import is_out_of_memory


class Latch:
    """Keeps the first error that it is set to, and raises it at every `check` from then on; any thread may set it.

    driven: the wheel velocities at the moment when the latch tripped, rad/s.
    unreported_interventions: stops of the deadman before that moment, which no tick has reported.
    reserve: the memory that a stop may need.
    """

    def __init__(self, reserve: Reserve | None = None) -> None:
        self.error: RobotcoreError | None = None
        self.driven = STOPPED
        self.unreported_interventions: Sequence[Intervention] = ()
        self._lock = RLock()
        self._reserve = reserve or Reserve(MonotonicClock())
        self._calls: list[Callable[[], object]] = []

    @property
    def cause(self) -> str:
        """What tripped it, as interventions name it. Only a watchdog latches the failure of a device or a backend."""
        return self.error.cause if isinstance(self.error, SafetyStop) else "watchdog"

    def interventions(self, now: float) -> tuple[Intervention, ...]:
        """Return what a trace is to tell of it."""
        return (*self.unreported_interventions, Intervention(now, self.cause, self.driven, STOPPED))

    def call(self, stop: Callable[[], object]) -> None:
        """Call this when the latch trips, after those that asked before: at once, in the thread that trips it."""
        self._calls.append(stop)

    def set(self, error: RobotcoreError) -> None:
        """Latch, and call every stop, whatever another one raises. Closing reports a stop that fails again."""
        with self._lock:
            self.error = self.error or error
        self._reserve.retry_on_memory_error(self._call_all)

    def _call_all(self) -> None:
        """Make the calls that are still to be made. One that runs out of memory twice is left for the next `set`."""
        for call in tuple(self._calls):
            try:
                self._reserve.retry_on_memory_error(call)
            except Exception as failure:  # noqa: BLE001  one that fails must not keep the others from stopping
                if is_out_of_memory(failure):
                    continue
            with suppress(ValueError):  # another thread has made it too
                self._calls.remove(call)

    def trip(self, error: RobotcoreError) -> NoReturn:
        """Latch, and raise what ended the run first."""
        self.set(error)
        raise self.error or error

    def check(self) -> None:
        """Raise what ended the run, if something did."""
        if self.error:
            raise self.error


class EmergencyStop:
    """A big red button: whoever holds it can press it, from any thread, and no app can undo it.

    >>> latch = Latch()
    >>> EmergencyStop(latch).press("the button on the bench was pressed")
    >>> str(latch.error)
    'e-stop: the button on the bench was pressed'
    """

    def __init__(self, latch: Latch) -> None:
        self._latch = latch

    def press(self, how: str) -> None:
        """Stop every motor at once, for good; the run ends as stopped, with ``how`` it came to that."""
        self._latch.set(EmergencyStopError(how))
