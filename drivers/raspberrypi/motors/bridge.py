"""The lines to a motor board that turn one motor."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack

from drivers.raspberrypi.claiming import claiming, pin_failure
from robotcore.hardware.motor_model import Output


class Bridge(Output):
    """These GPIOs of a motor, and how to let go of them."""

    def __init__(self, motor: str, gpios: Sequence[int], opened: ExitStack) -> None:
        self.motor, self.gpios, self._opened = motor, gpios, opened

    @abstractmethod
    def put(self, duty: float) -> None:
        """Put a duty on the lines; at 0 no line's failure keeps another one from going low."""

    def turn(self, duty: float) -> None:
        try:
            self.put(whole_percent(duty))
        except Exception as error:
            raise pin_failure(self.motor, self.gpios, error) from error

    def close(self) -> None:
        """Let go of each line, even where another one fails."""
        with claiming(self.motor, self.gpios):
            self._opened.close()


def whole_percent(duty: float) -> float:
    """Return the nearest duty in whole percent, such that lgpio, which cuts ``int(duty * 100)``, sends just that.

    One percent is the resolution of every motor here, on simulated pins too: of
    ``forward_rad_s / (1 - dead_band)``, so 0.16 rad/s for a wheel of 14 rad/s with a dead band of 0.1.

    >>> int(0.29 * 100), int(whole_percent(0.29) * 100)
    (28, 29)
    """
    return _PERCENT[round(abs(duty) * 100)] if duty >= 0 else -_PERCENT[round(abs(duty) * 100)]


_PERCENT = tuple(
    percent / 100 if int(percent / 100 * 100) == percent else math.nextafter(percent / 100, 1) for percent in range(101)
)
