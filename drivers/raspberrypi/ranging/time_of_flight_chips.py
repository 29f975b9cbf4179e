"""ST's time-of-flight chips, by Adafruit's libraries: measurements with the chip's own status."""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any, ClassVar

from robotcore.errors import DeviceError


class RangeStatus(Enum):
    """The status of a measurement that the chip reports."""

    TARGET = auto()
    """A target at the measured distance."""

    TOO_NEAR = auto()
    """A target nearer than the chip can measure."""

    BEYOND = auto()
    """A target farther than the chip can measure."""

    NOTHING = auto()
    """Too little light came back: there is no target, or a dark target."""

    UNCLEAR = auto()
    """The chip reports no valid result."""

    BROKEN = auto()
    """The chip's own check of its laser failed."""


@dataclass(frozen=True)
class Measurement:
    """A measurement of a time-of-flight chip."""

    status: RangeStatus

    distance: float
    """The distance in metres, valid only for `RangeStatus.TARGET`."""


class LightChip(ABC):
    """A time-of-flight chip, which measures continuously after the construction of this object.

    The status and the distance are read in one transaction, so that they belong to the same measurement. Adafruit's
    libraries do not do this. The methods raise the errors of these libraries.
    """

    reach: ClassVar[float]
    """The longest distance that the chip can measure, in metres."""

    _result: ClassVar[bytes]
    """The register with the status. The distance in mm, high byte first, is ``_distance`` bytes after the status."""

    _distance: ClassVar[int]
    _statuses: ClassVar[Mapping[int, RangeStatus]]

    def __init__(self, bus: Any, address: int, max_range: float) -> None:
        from adafruit_bus_device.i2c_device import I2CDevice

        self._registers = I2CDevice(bus, address)
        self._library = self._begin(bus, address, max_range)

    def measure(self) -> Measurement | None:
        """Return the newest measurement; None without a new measurement since the last call."""
        if not self._library.data_ready:
            return None
        result = bytearray(self._distance + 2)
        with self._registers as registers:
            registers.write(self._result)
            registers.readinto(result)
        self._clear()
        millimetres = int.from_bytes(result[self._distance :], "big")
        return Measurement(self._statuses.get(self._status(result[0]), RangeStatus.UNCLEAR), millimetres / 1000)

    @abstractmethod
    def stop(self) -> None:
        """Stop measuring."""

    @abstractmethod
    def _begin(self, bus: Any, address: int, max_range: float) -> Any:
        """Start measuring, and return the library's object for the chip."""

    @abstractmethod
    def _status(self, register: int) -> int:
        """Return the status in the value of the register ``_result``."""

    @abstractmethod
    def _clear(self) -> None:
        """Let the chip store the next measurement."""


class VL53L0XChip(LightChip):
    """A VL53L0X. A measurement takes 33 ms.

    Source: ST's API (STSW-IMG005), VL53L0X_DEVICEERROR_…, VL53L0X_get_pal_range_status and GetRangingMeasurementData.
    """

    reach = 1.2
    _result, _distance = b"\x14", 10
    _statuses: ClassVar[Mapping[int, RangeStatus]] = {
        1: RangeStatus.BROKEN,
        2: RangeStatus.BROKEN,
        3: RangeStatus.BROKEN,
        4: RangeStatus.NOTHING,
        6: RangeStatus.BEYOND,
        9: RangeStatus.BEYOND,
        10: RangeStatus.TOO_NEAR,
        11: RangeStatus.TARGET,
    }

    def stop(self) -> None:
        self._library.stop_continuous()

    def _begin(self, bus: Any, address: int, max_range: float) -> Any:
        from adafruit_vl53l0x import VL53L0X

        library = VL53L0X(bus, address, io_timeout_s=1.0)
        library.start_continuous()
        return library

    def _status(self, register: int) -> int:
        return register >> 3 & 0x0F

    def _clear(self) -> None:
        self._library.read_range()


class VL53L1XChip(LightChip):
    """A VL53L1X. A measurement takes 50 ms.

    If ``max_range`` is at most 1.3 m, the chip uses its short mode, which daylight disturbs less.

    Source: ST's ultra lite driver (STSW-IMG009), VL53L1X_GetRangeStatus and VL53L1X_GetResult, and its manual, UM2510.
    """

    reach = 3.6
    _result, _distance = b"\x00\x89", 13
    _statuses: ClassVar[Mapping[int, RangeStatus]] = {
        1: RangeStatus.BROKEN,
        2: RangeStatus.BROKEN,
        3: RangeStatus.BROKEN,
        4: RangeStatus.NOTHING,
        5: RangeStatus.BEYOND,
        7: RangeStatus.BEYOND,
        8: RangeStatus.TOO_NEAR,
        9: RangeStatus.TARGET,
    }
    _SHORT_REACH = 1.3
    _FIRST_TRANSACTIONS = 300
    """The maximum number of transactions until the first measurement. The set-up takes 40. Then the library requests a
    measurement every 10 ms, by two transactions."""

    def stop(self) -> None:
        self._library.stop_ranging()

    def _begin(self, bus: Any, address: int, max_range: float) -> Any:
        from adafruit_vl53l1x import VL53L1X

        limit = TransactionLimit(bus, self._FIRST_TRANSACTIONS)
        library = VL53L1X(limit, address)
        limit.lift()
        library.distance_mode = 1 if max_range <= self._SHORT_REACH else 2
        library.start_ranging()
        return library

    def _status(self, register: int) -> int:
        return register & 0x1F

    def _clear(self) -> None:
        self._library.clear_interrupt()


class TransactionLimit:
    """An I2C bus that raises TimeoutError after ``transactions`` transactions, unless `lift` was called before.

    It ends the wait of the VL53L1X's library for the first measurement, which has no time limit.
    """

    def __init__(self, bus: Any, transactions: int) -> None:
        self._bus = bus
        self._left: float = transactions

    def lift(self) -> None:
        """Allow any number of transactions from now on."""
        self._left = math.inf

    def try_lock(self) -> bool:
        """Begin a transaction; raises TimeoutError at the limit."""
        if self._left <= 0:
            raise TimeoutError("the chip does not measure")
        self._left -= 1
        return bool(self._bus.try_lock())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)


_LIBRARY_LOCK = threading.Lock()
"""Lets only one thread at a time call Adafruit's libraries, because all their sensors share one buffer."""


@dataclass(frozen=True)
class ChipAddress:
    """The I2C bus and the address of the chip of a device.

    >>> str(ChipAddress("nose", bus=1, address=0x29))
    'I2C 0x29 on bus 1'
    """

    device: str
    """The device's name, for errors."""

    bus: int
    """The number of the I2C bus."""

    address: int
    """The 7-bit address of the chip on the bus."""

    def __str__(self) -> str:
        return f"I2C 0x{self.address:02x} on bus {self.bus}"


class I2CChip:
    """A time-of-flight chip on an I2C bus. The constructor and every method except `close` raise DeviceError."""

    def __init__(self, kind: type[LightChip], chip_address: ChipAddress, max_range: float) -> None:
        self._chip_address = chip_address
        with _translate_errors(chip_address), ExitStack() as undo:
            from adafruit_extended_bus import ExtendedI2C

            bus = ExtendedI2C(chip_address.bus, frequency=None)  # Linux sets the frequency at boot
            undo.callback(bus.deinit)
            self._chip = kind(bus, chip_address.address, max_range)
            self._undo = undo.pop_all()

    def measure(self) -> Measurement | None:
        """Return the newest measurement; None without a new measurement since the last call."""
        with _translate_errors(self._chip_address):
            return self._chip.measure()

    def close(self) -> None:
        """Stop the laser, if the chip still answers, and close the bus."""
        with self._undo, suppress(DeviceError), _translate_errors(self._chip_address):
            self._chip.stop()


@contextmanager
def _translate_errors(chip_address: ChipAddress) -> Iterator[None]:
    try:
        with _LIBRARY_LOCK:
            yield
    except ImportError as error:
        message = f"its library is not installed ({error}); pip install 'robotcore[tof]'"
        raise DeviceError(chip_address.device, message, kind="library-missing") from error
    except Exception as error:
        message = (
            f"no answer at {chip_address} ({error}). Switch I2C on (raspi-config). Check SDA, SCL, 3.3 V, ground, and "
            "the chip's name in the robot's file"
        )
        raise DeviceError(chip_address.device, message, kind="chip-unanswered") from error
