"""The GPIO chip of the header, for a process that holds lines beside the app's pin factory."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from drivers.raspberrypi.holders import held_by
from drivers.raspberrypi.lg import chip_number, load
from robotcore.errors import BackendError

AT_THE_DESK = "At the desk: --backend virtualpi"


class HeldError(BackendError):
    """A line is another process's."""


class Chip:
    """Open until `close`, which frees what was claimed; a Raspberry Pi's kernel lets a freed line keep its level."""

    def __init__(self) -> None:
        """Raises BackendError where the chip cannot be opened."""
        self._lgpio, number = load(), chip_number()
        try:
            self._handle = self._lgpio.gpiochip_open(number)
        except self._lgpio.error as error:
            raise BackendError(why_closed(number)) from error

    def claim_low(self, gpios: Sequence[int]) -> None:
        """Make lines low outputs of this process; those that it has claimed before stay as they are.

        Pulled down, they are low too when nobody drives them any more. All are tried. Raises HeldError where another
        process has one.
        """
        if held := [gpio for gpio in gpios if not self._is_claimed(gpio)]:
            words = "; ".join(f"GPIO {gpio} is held by {held_by(gpio)}" for gpio in held)
            raise HeldError(f"{words}. End that program first")

    def write(self, gpio: int, *, is_high: bool) -> None:
        """Set the level of a line that is claimed."""
        self._lgpio.gpio_write(self._handle, gpio, int(is_high))

    def close(self) -> None:
        self._lgpio.gpiochip_close(self._handle)

    def _is_claimed(self, gpio: int) -> bool:
        try:
            self._lgpio.gpio_claim_output(self._handle, gpio, 0, self._lgpio.SET_PULL_DOWN)
        except self._lgpio.error as error:
            if error.value != self._lgpio.error_text(self._lgpio.GPIO_BUSY):
                raise
            return False
        return True


def why_closed(number: int) -> str:
    """Return why a chip could not be opened, and what to do, which lgpio does not tell."""
    chip = Path(f"/dev/gpiochip{number}")
    if not chip.exists():
        return f"there is no {chip}: this is no Raspberry Pi. {AT_THE_DESK}"
    if not os.access(chip, os.R_OK | os.W_OK):
        return f"no permission for {chip}. sudo usermod -aG gpio $USER, then log in again"
    return f"{chip} cannot be opened. Run robotcore doctor on the robot"
