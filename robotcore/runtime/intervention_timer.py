"""Measures how long each cause of interventions changes the commands of a run."""

from __future__ import annotations

from collections.abc import Iterable

from robotcore.runtime.trace import TickRecord

_DIGITS = 6
"""The number of decimals of a duration. A sum of ticks has rounding errors."""


class InterventionTimer:
    """Adds up the duration of each cause of interventions, from the records of a run's ticks.

    A changed command lasts until the app's next command. A stop between two ticks lasts from the stop until the app's
    next command.

    >>> from robotcore.geometry import Wheels
    >>> from robotcore.safety.velocity_limits import Intervention
    >>> forward, still = Wheels(5.0, 5.0), Wheels(0.0, 0.0)
    >>> timer = InterventionTimer()
    >>> timer.add(TickRecord(0, 0.0, "drive", forward, still, (Intervention(0.0, "range guard", forward, still),)))
    >>> timer.add(TickRecord(1, 0.05, "drive", forward, forward, ()))
    >>> timer.measure()
    {'range guard': 0.05}
    """

    def __init__(self) -> None:
        self._seconds: dict[str, float] = {}
        self._active: Iterable[str] = ()
        """The causes that changed the command in force."""
        self._time = 0.0

    def add(self, record: TickRecord) -> None:
        """Add the record of the next tick."""
        if not (record.interventions or self._active):
            return  # Nearly every tick ends here.
        for cause in self._active:
            self._seconds[cause] += record.time - self._time
        self._time = record.time
        for each in record.interventions:
            before_tick = max(0.0, record.time - each.time)
            self._seconds[each.cause] = self._seconds.get(each.cause, 0.0) + before_tick
        if record.interventions or record.lost or record.asked is not None:
            is_ended = record.asked is not None  # the new command ends a stop that came before this tick
            self._active = {each.cause for each in record.interventions if not (is_ended and each.time < record.time)}

    def measure(self) -> dict[str, float]:
        """Return the duration of each cause in seconds, in the order of their first interventions.

        Another thread may call this method during `add`.
        """
        return {cause: round(seconds, _DIGITS) for cause, seconds in self._seconds.copy().items()}
