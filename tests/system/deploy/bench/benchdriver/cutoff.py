"""What stands in for a line that is pulled low."""

from __future__ import annotations

from robotcore.hal.cutoff import Cutoff

from .diary import note


class Written(Cutoff):
    """Writes that a motor stands."""

    def __init__(self, motor: str) -> None:
        self._motor = motor

    def open(self) -> None:
        """Need nothing."""

    def stop(self) -> None:
        note("cutoff", self._motor, 0.0)

    def close(self) -> None:
        """Have nothing to give back."""
