"""Devices that are lost for a while: how long a run stands and waits for them."""

from __future__ import annotations

from robotcore.errors import DeviceLostError


class Outages:
    """Tells whether a run may go on without a device that is lost, for up to ``limit`` seconds at a time.

    ``lost`` are the names of those that are, in the order in which they were missed: it ends when all are back.
    """

    def __init__(self, limit: float) -> None:
        self.lost: list[str] = []
        self._limit = limit
        self._since = 0.0
        self._told: list[tuple[str, float]] = []

    @property
    def are_borne(self) -> bool:
        """Whether a loss is waited for at all."""
        return self._limit > 0

    def bears(self, lost: DeviceLostError, now: float) -> bool:
        """Take in a tick in which a device was lost; return whether there may be another one."""
        if not self.are_borne:
            return False
        if not self.lost:
            self._since = now
        if lost.device not in self.lost:
            self.lost.append(lost.device)
        return now - self._since < self._limit

    def end(self, now: float) -> None:
        """Take in a tick in which nothing was lost."""
        if self.lost:
            self._told.append((self.lost[0], now - self._since))
            self.lost.clear()

    def notes(self, now: float) -> tuple[str, ...]:
        """Return what the end of a run tells: which devices, how often, how long in all; and what was not back."""
        names = sorted({name for name, _ in self._told})
        away = f"{', '.join(self.lost)} was lost for the last {now - self._since:.1f} s; the robot stood"
        return (*map(self._note, names), *([away] if self.lost else ()))

    def _note(self, device: str) -> str:
        lengths = [length for name, length in self._told if name == device]
        often = "once" if len(lengths) == 1 else f"{len(lengths)} times"
        return f"{device} was lost {often}, {sum(lengths):.1f} s in all, and came back; the robot stood meanwhile"
