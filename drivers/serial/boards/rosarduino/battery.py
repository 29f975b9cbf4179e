"""A battery's voltage, as our firmware measures it by a divider."""

from __future__ import annotations

from drivers.serial.boards.rosarduino.protocol import Answer
from robotcore.devices import Voltage
from robotcore.errors import DeviceError

NOT_WIRED = (
    "the board's firmware was built without a battery; name the pin of its divider, BATTERY_PIN in config.h, and flash "
    "it again"
)


class Voltages:
    """Keeps what the board has told last."""

    def __init__(self, device: str) -> None:
        self._device = device
        self._newest: Voltage | None = None
        self._is_wired = True

    def take(self, answer: Answer, now: float) -> None:
        """Take an answer in mV, negative where no battery is wired."""
        if answer.is_refusal:
            return
        millivolts = answer.numbers[0]
        self._is_wired = millivolts >= 0
        if self._is_wired:
            self._newest = Voltage(millivolts / 1000, now, self._newest.sequence + 1 if self._newest else 0)

    def newest(self) -> Voltage | None:
        """Return the newest voltage, None where there was none yet; raises DeviceError where none is measured."""
        if not self._is_wired:
            raise DeviceError(self._device, NOT_WIRED)
        return self._newest
