"""A time-of-flight chip at its place on an I2C bus, and the one place where errors of the bus become a device's."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass

from drivers.raspberrypi.ranging.lightchips import LightChip, Measurement
from robotcore.errors import DeviceError

_LIBRARY = threading.Lock()
"""Adafruit's libraries have one buffer for all their sensors."""


@dataclass(frozen=True)
class Place:
    """Where a device's chip is: the number of the bus, and its address there."""

    device: str
    bus: int
    address: int

    def __str__(self) -> str:
        return f"I2C 0x{self.address:02x} on bus {self.bus}"


class I2CChip:
    """A chip that is connected. Making it, and every call, raises DeviceError."""

    def __init__(self, kind: type[LightChip], place: Place, max_range: float) -> None:
        self._place = place
        with _translated(place), ExitStack() as undo:
            from adafruit_extended_bus import ExtendedI2C

            bus = ExtendedI2C(place.bus, frequency=None)  # Linux sets it at boot
            undo.callback(bus.deinit)
            self._chip = kind(bus, place.address, max_range)
            self._undo = undo.pop_all()

    def measure(self) -> Measurement | None:
        """Return the newest measurement, once; None where there is no newer."""
        with _translated(self._place):
            return self._chip.measure()

    def close(self) -> None:
        """Let the laser rest, if the chip still answers, and let the bus go."""
        with self._undo, suppress(DeviceError), _translated(self._place):
            self._chip.stop()


@contextmanager
def _translated(place: Place) -> Iterator[None]:
    try:
        with _LIBRARY:
            yield
    except ImportError as error:
        fault = f"its library is not installed ({error}); pip install 'robotcore[tof]'"
        raise DeviceError(place.device, fault) from error
    except Exception as error:
        fault = (
            f"no answer at {place} ({error}); is I2C switched on (raspi-config), are SDA, SCL, 3.3 V and ground "
            "connected, and is it the chip that the robot's file names"
        )
        raise DeviceError(place.device, fault) from error
