"""ST's time-of-flight chips, by Adafruit's libraries: what a measurement says, by the chip's own status."""

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
    """What a measurement says."""

    TARGET = auto()
    """Something, at the distance that is told with it."""
    TOO_NEAR = auto()
    BEYOND = auto()
    """Something, from farther away than can be measured."""
    NOTHING = auto()
    """Too little light came back: there is nothing, or it is dark."""
    UNCLEAR = auto()
    BROKEN = auto()
    """The chip's own check of its laser has failed."""


@dataclass(frozen=True)
class Measurement:
    """What was seen, and the distance in metres that is told with it."""

    status: RangeStatus
    distance: float


class LightChip(ABC):
    """A chip that measures by itself, again and again, from when it is made on. Raises what its library raises.

    Status and distance are read at once, so that they are of the same measurement; the libraries read one of them, or
    one after the other.
    """

    reach: ClassVar[float]
    """How far it sees, in metres."""
    _result: ClassVar[bytes]
    """The register of the status; the distance in millimetres follows ``_distance`` bytes later, high byte first."""
    _distance: ClassVar[int]
    _statuses: ClassVar[Mapping[int, RangeStatus]]
    """What a status says."""

    def __init__(self, bus: Any, address: int, max_range: float) -> None:
        from adafruit_bus_device.i2c_device import I2CDevice

        self._registers = I2CDevice(bus, address)
        self._library = self._begin(bus, address, max_range)

    def measure(self) -> Measurement | None:
        """Return the newest measurement, once; None where there is no newer."""
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
        """Let the laser rest."""

    @abstractmethod
    def _begin(self, bus: Any, address: int, max_range: float) -> Any:
        """Return the library's sensor, measuring."""

    @abstractmethod
    def _status(self, register: int) -> int:
        """Return the status in its register."""

    @abstractmethod
    def _clear(self) -> None:
        """Say that the measurement was taken."""


class VL53L0XChip(LightChip):
    """Measures in 33 ms, as the chip is set up by default.

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
    """Measures in 50 ms; where a short range is enough, in the mode that daylight disturbs less.

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
    """Setting it up takes 40; the library asks whether it has measured every 10 ms, which takes two."""

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
    """A bus that raises TimeoutError after so many transactions, unless it is freed by then.

    Setting up a VL53L1X, its library waits for a first measurement for ever.
    """

    def __init__(self, bus: Any, transactions: int) -> None:
        self._bus = bus
        self._left: float = transactions

    def lift(self) -> None:
        """Let any number of transactions follow."""
        self._left = math.inf

    def try_lock(self) -> bool:
        """Begin a transaction."""
        if self._left <= 0:
            raise TimeoutError("it does not measure")
        self._left -= 1
        return bool(self._bus.try_lock())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)


_LIBRARY_LOCK = threading.Lock()
"""Adafruit's libraries have one buffer for all their sensors."""


@dataclass(frozen=True)
class ChipAddress:
    """Where a device's chip is: the number of the bus, and its address there."""

    device: str
    bus: int
    address: int

    def __str__(self) -> str:
        return f"I2C 0x{self.address:02x} on bus {self.bus}"


class I2CChip:
    """A chip that is connected. Making it, and every call, raises DeviceError."""

    def __init__(self, kind: type[LightChip], chip_address: ChipAddress, max_range: float) -> None:
        self._chip_address = chip_address
        with _translate_errors(chip_address), ExitStack() as undo:
            from adafruit_extended_bus import ExtendedI2C

            bus = ExtendedI2C(chip_address.bus, frequency=None)  # Linux sets it at boot
            undo.callback(bus.deinit)
            self._chip = kind(bus, chip_address.address, max_range)
            self._undo = undo.pop_all()

    def measure(self) -> Measurement | None:
        """Return the newest measurement, once; None where there is no newer."""
        with _translate_errors(self._chip_address):
            return self._chip.measure()

    def close(self) -> None:
        """Let the laser rest, if the chip still answers, and let the bus go."""
        with self._undo, suppress(DeviceError), _translate_errors(self._chip_address):
            self._chip.stop()


@contextmanager
def _translate_errors(chip_address: ChipAddress) -> Iterator[None]:
    try:
        with _LIBRARY_LOCK:
            yield
    except ImportError as error:
        fault = f"its library is not installed ({error}); pip install 'robotcore[tof]'"
        raise DeviceError(chip_address.device, fault, kind="library-missing") from error
    except Exception as error:
        fault = (
            f"no answer at {chip_address} ({error}); is I2C switched on (raspi-config), are SDA, SCL, 3.3 V and ground "
            "connected, and is it the chip that the robot's file names"
        )
        raise DeviceError(chip_address.device, fault, kind="chip-unanswered") from error
