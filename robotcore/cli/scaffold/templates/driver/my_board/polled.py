"""A sensor's samples, asked for beside the app: no read waits for an answer."""

from collections.abc import Callable
from typing import Generic

from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import SampleT
from robotcore.hardware import LatestSample

from my_board.failures import in_words

PERIOD_S = 0.02


class Polled(Generic[SampleT]):
    """Calls ``take(time, sequence)`` once a period, and keeps what it returned last.

    Raises DeviceError where the first call fails. A later failure is raised by `newest`, until a call succeeds again.
    """

    def __init__(self, device: str, clock: Clock, take: Callable[[float, int], SampleT]) -> None:
        self._device, self._clock, self._take = device, clock, take
        self._sequence = 0
        self._newest = LatestSample(device, self._ask())
        self._polling = clock.every(PERIOD_S, self._poll, device)

    def newest(self) -> SampleT:
        """Return the newest sample."""
        return self._newest.get()

    def stop(self) -> None:
        """Ask no more."""
        self._polling.stop()

    def _poll(self) -> None:
        try:
            self._newest.put(self._ask())
        except DeviceError as error:
            self._newest.fail(error)

    def _ask(self) -> SampleT:
        with in_words(self._device):
            sample = self._take(self._clock.now(), self._sequence)
        self._sequence += 1
        return sample
