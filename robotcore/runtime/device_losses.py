"""The losses of devices in a run: whether it waits for a lost device, and their summary."""

from __future__ import annotations

from robotcore.errors import DeviceLostError


class DeviceLossTracker:
    """Decides whether a run waits for lost devices, and summarises the losses.

    limit: the longest time for which a device may be lost, in seconds. With 0, each loss ends the run.
    """

    def __init__(self, limit: float) -> None:
        self.lost: list[str] = []
        """The names of the lost devices, in the order of their losses. The list is emptied when all are back."""
        self._limit = limit
        self._since = 0.0
        self._past_losses: list[tuple[str, float]] = []

    @property
    def is_enabled(self) -> bool:
        """Whether a run waits for lost devices."""
        return self._limit > 0

    def tolerate(self, lost: DeviceLostError, now: float) -> bool:
        """Record a tick in which a device was lost. Return whether the run waits for the device.

        lost: the error of the device.
        now: the time of the tick, in seconds.
        """
        if not self.is_enabled:
            return False
        if not self.lost:
            self._since = now
        if lost.device not in self.lost:
            self.lost.append(lost.device)
        return now - self._since < self._limit

    def end(self, now: float) -> None:
        """Record the end of all losses: a tick in which no device was lost, or the end of a live robot's call."""
        if self.lost:
            self._past_losses.append((self.lost[0], now - self._since))
            self.lost.clear()

    def summarise(self, now: float) -> tuple[str, ...]:
        """Return a sentence for each device that was lost: how many times, and how long in total."""
        names = sorted({name for name, _ in self._past_losses})
        away = f"{', '.join(self.lost)} was lost for the last {now - self._since:.1f} s. The robot stood still"
        return (*map(self._summarise_device, names), *([away] if self.lost else ()))

    def _summarise_device(self, device: str) -> str:
        lengths = [length for name, length in self._past_losses if name == device]
        often = "once" if len(lengths) == 1 else f"{len(lengths)} times"
        return f"{device} was lost {often}, for {sum(lengths):.1f} s in total. The robot stood still meanwhile"
