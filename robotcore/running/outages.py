"""Devices that are lost for a while: how long a run stands and waits for them."""

from __future__ import annotations

from robotcore.errors import DeviceLostError


class Outages:
    """Tells whether a run may go on without a device that is lost, for up to ``limit`` seconds at a time."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._since: float | None = None
        self._lost = ""
        self._told: list[tuple[str, float]] = []

    def bears(self, lost: DeviceLostError, now: float) -> bool:
        """Take in a tick in which a device was lost; return whether there may be another one."""
        if self._since is None:
            self._since, self._lost = now, lost.device
        return now - self._since < self._limit

    def end(self, now: float) -> None:
        """Take in a tick in which nothing was lost."""
        if self._since is not None:
            self._told.append((self._lost, now - self._since))
            self._since = None

    @property
    def notes(self) -> tuple[str, ...]:
        """What the end of a run tells of those that are over: which devices, how often, how long in all."""
        names = sorted({name for name, _ in self._told})
        return tuple(map(self._note, names))

    def _note(self, device: str) -> str:
        lengths = [length for name, length in self._told if name == device]
        often = "once" if len(lengths) == 1 else f"{len(lengths)} times"
        return f"{device} was lost {often}, {sum(lengths):.1f} s in all, and came back; the robot stood meanwhile"
