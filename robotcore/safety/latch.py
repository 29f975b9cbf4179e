"""The latch and the emergency stop. A tripped latch ends the run, whatever the app catches."""

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


class Latch:
    """Keeps the first error, and raises it at every `check` from then on. Any thread may trip it.

    reserve: the memory that a stop may need.

    >>> latch = Latch()
    >>> latch.call(lambda: print("the motors are stopped"))
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
        """The first error; None until the latch trips."""
        self.driven = STOPPED
        """The wheel velocities at the moment when the latch tripped, in rad/s."""
        self.unreported_interventions: Sequence[Intervention] = ()
        """Stops of the deadman before that moment, which no tick has reported."""
        self._lock = RLock()
        self._reserve = reserve or Reserve(MonotonicClock())
        self._calls: list[Callable[[], object]] = []

    def __repr__(self) -> str:
        return f"Latch(error={str(self.error)!r})" if self.error else "Latch()"

    @property
    def cause(self) -> str:
        """The cause, as interventions name it. Only a watchdog latches the failure of a device or a backend."""
        return self.error.cause if isinstance(self.error, SafetyStop) else "watchdog"

    def interventions(self, now: float) -> tuple[Intervention, ...]:
        """Return the interventions for the trace: those that no tick reported, and the one of the latch itself."""
        return (*self.unreported_interventions, Intervention(now, self.cause, self.driven, STOPPED))

    def call(self, stop: Callable[[], object]) -> None:
        """Add a function to call when the latch trips, in the thread that trips it. The order of adding is kept."""
        self._calls.append(stop)

    def set(self, error: RobotcoreError) -> None:
        """Keep the error, and call every function, even if one raises. A stop that fails is tried again at closing."""
        with self._lock:
            self.error = self.error or error
        self._reserve.retry_on_memory_error(self._call_all)

    def _call_all(self) -> None:
        """Make the outstanding calls. A call that runs out of memory twice is left for the next `set`."""
        for call in tuple(self._calls):
            try:
                self._reserve.retry_on_memory_error(call)
            except Exception as failure:  # noqa: BLE001  one failure must not prevent the other stops
                if is_out_of_memory(failure):
                    continue
            with suppress(ValueError):  # another thread has made it too
                self._calls.remove(call)

    def trip(self, error: RobotcoreError) -> NoReturn:
        """Keep the error, and raise the first one."""
        self.set(error)
        raise self.error or error

    def check(self) -> None:
        """Raise the first error, if there is one."""
        if self.error:
            raise self.error


class EmergencyStop:
    """Stops every motor for good, from any thread. No app can undo it.

    >>> latch = Latch()
    >>> EmergencyStop(latch).press("the button on the bench was pressed")
    >>> str(latch.error)
    'e-stop: the button on the bench was pressed'
    """

    def __init__(self, latch: Latch) -> None:
        self._latch = latch

    def press(self, how: str) -> None:
        """Stop every motor at once and end the run as stopped. The result's reason contains ``how``."""
        self._latch.set(EmergencyStopError(how))
