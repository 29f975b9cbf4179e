"""What ends a run for good: once tripped, it stays so, whatever the app catches."""

from __future__ import annotations

from typing import NoReturn

from robotcore.errors import SafetyStop


class Latch:
    """Keeps the first safety stop and raises it at every `check` from then on."""

    def __init__(self) -> None:
        self._stop: SafetyStop | None = None

    def trip(self, stop: SafetyStop) -> NoReturn:
        """Latch, and raise what ended the run first."""
        self._stop = self._stop or stop
        raise self._stop

    def check(self) -> None:
        """Raise what ended the run, if something did."""
        if self._stop:
            raise self._stop
