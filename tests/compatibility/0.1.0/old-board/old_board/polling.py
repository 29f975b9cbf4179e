"""Poll a sensor in the background, so that an app does not wait for the board."""

from collections.abc import Callable
from typing import Generic

from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.device import SampleT
from robotcore.hardware import NewestSample

from old_board.error_translation import translate_errors

PERIOD_S = 0.02


class PolledSensor(Generic[SampleT]):
    """Calls ``read(time, sequence)`` every `PERIOD_S` seconds, and stores the sample.

    Raises DeviceError if the first call fails. After a later failure, `newest` raises the error until a call succeeds.
    """

    def __init__(self, device: str, clock: Clock, read: Callable[[float, int], SampleT]) -> None:
        self._device, self._clock, self._read = device, clock, read
        self._sequence = 0
        self._newest = NewestSample(device, self._measure())
        self._polling = clock.call_every(PERIOD_S, self._poll, device)

    def newest(self) -> SampleT:
        """Return the newest sample."""
        return self._newest.get()

    def stop(self) -> None:
        """Stop polling."""
        self._polling.stop()

    def _poll(self) -> None:
        try:
            self._newest.put(self._measure())
        except DeviceError as error:
            self._newest.fail(error)

    def _measure(self) -> SampleT:
        with translate_errors(self._device):
            sample = self._read(self._clock.now(), self._sequence)
        self._sequence += 1
        return sample
