"""The drivers of ST's VL53L0X and VL53L1X, range sensors that measure a laser's time of flight, on an I2C bus."""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from drivers.raspberrypi.header import HEADER_BUS, gpio
from robotcore.description import RangeSensorDescription, RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import RangeSensor
from robotcore.hardware import Connection, DeviceDriver, Drivers, Host, SampledRangeSensor
from robotcore.hardware.polled_samples import RangeSampler, require_timely

Status = Literal["target", "too near", "beyond", "no light", "broken"]
"""The status that a chip reports with a measurement.

Only the distance of a "target" is valid. "no light" means that too little light came back: there is no target, or a
dark target. "broken" means that the chip's own check of its laser failed.
"""


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
    _mask: ClassVar[int]
    """The bits of the status in its register."""

    _shift: ClassVar[int]
    """The number of bits below the status in its register."""

    _statuses: ClassVar[Mapping[int, Status]]

    def __init__(self, bus: Any, address: int, max_range: float) -> None:
        from adafruit_bus_device.i2c_device import I2CDevice

        self._registers = I2CDevice(bus, address)
        self._library = self._begin(bus, address, max_range)

    def measure(self) -> tuple[Status | None, float] | None:
        """Return the status and the distance in metres; None without a new measurement since the last call.

        The status is None if the chip reports no valid result.
        """
        if not self._library.data_ready:
            return None
        result = bytearray(self._distance + 2)
        with self._registers as registers:
            registers.write(self._result)
            registers.readinto(result)
        self._clear()
        millimetres = int.from_bytes(result[self._distance :], "big")
        return self._statuses.get((result[0] & self._mask) >> self._shift), millimetres / 1000

    @abstractmethod
    def stop(self) -> None:
        """Stop measuring."""

    @abstractmethod
    def _begin(self, bus: Any, address: int, max_range: float) -> Any:
        """Start measuring, and return the library's object for the chip."""

    @abstractmethod
    def _clear(self) -> None:
        """Let the chip store the next measurement."""


class VL53L0XChip(LightChip):
    """A VL53L0X. A measurement takes 33 ms.

    Source: ST's API (STSW-IMG005), VL53L0X_DEVICEERROR_…, VL53L0X_get_pal_range_status and GetRangingMeasurementData.
    """

    reach = 1.2
    _result, _distance, _mask, _shift = b"\x14", 10, 0x78, 3
    _statuses: ClassVar[Mapping[int, Status]] = {
        **dict.fromkeys((1, 2, 3), "broken"),
        4: "no light",
        **dict.fromkeys((6, 9), "beyond"),
        10: "too near",
        11: "target",
    }

    def stop(self) -> None:
        self._library.stop_continuous()

    def _begin(self, bus: Any, address: int, max_range: float) -> Any:
        from adafruit_vl53l0x import VL53L0X

        library = VL53L0X(bus, address, io_timeout_s=1.0)
        library.start_continuous()
        return library

    def _clear(self) -> None:
        self._library.read_range()


class VL53L1XChip(LightChip):
    """A VL53L1X. A measurement takes 50 ms.

    If ``max_range`` is at most 1.3 m, the chip uses its short mode, which daylight disturbs less.

    Source: ST's ultra lite driver (STSW-IMG009), VL53L1X_GetRangeStatus and VL53L1X_GetResult, and its manual, UM2510.
    """

    reach = 3.6
    _result, _distance, _mask, _shift = b"\x00\x89", 13, 0x1F, 0
    _statuses: ClassVar[Mapping[int, Status]] = {
        **dict.fromkeys((1, 2, 3), "broken"),
        4: "no light",
        **dict.fromkeys((5, 7), "beyond"),
        8: "too near",
        9: "target",
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
        limit.left = math.inf
        library.distance_mode = 1 if max_range <= self._SHORT_REACH else 2
        library.start_ranging()
        return library

    def _clear(self) -> None:
        self._library.clear_interrupt()


class TransactionLimit:
    """An I2C bus that raises TimeoutError after ``left`` transactions.

    It ends the wait of the VL53L1X's library for the first measurement, which has no time limit.
    """

    def __init__(self, bus: Any, left: float) -> None:
        self._bus, self.left = bus, left

    def try_lock(self) -> bool:
        """Begin a transaction; raises TimeoutError at the limit."""
        if self.left <= 0:
            raise TimeoutError("the chip does not measure")
        self.left -= 1
        return bool(self._bus.try_lock())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)


class TimeOfFlight(DeviceDriver):
    """The base class of the drivers of both chips.

    A distance is `inf` if the chip reports a target beyond its range, or after ``echo_free_cycles`` measurements with
    too little light. A single measurement with too little light makes no sample, because the target may be dark.
    """

    described = RangeSensorDescription
    remedy = "On the Pi: pip install 'robotcore[tof]'"
    chip: ClassVar[type[LightChip]]

    bus: Annotated[int, Field(ge=0, le=30)] = HEADER_BUS
    """The number of the chip's I2C bus."""

    address: Annotated[int, Field(ge=0x08, le=0x77)] = 0x29
    """The 7-bit address of the chip on the bus."""

    cycle_s: Annotated[float, Field(ge=0.02, le=1)] = 0.05
    """The time between two reads of the chip, in seconds."""

    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] = 10
    """After this many cycles in a row with too little light, the sample is `inf`. With 0, a cycle with too little
    light never makes a sample."""

    @property
    def place(self) -> str:
        return f"0x{self.address:02x} on bus {self.bus}"

    def check(self, description: RangeSensorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if description.max_range_m > self.chip.reach:
            raise ValueError(
                f"the range of a {self.name.upper()} is {self.chip.reach:g} m, but max_range_m is "
                f"{description.max_range_m:g}; lower it"
            )
        require_timely(self.echo_free_cycles, self.cycle_s, robot)

    def connections(self) -> Sequence[Connection]:
        if self.bus == HEADER_BUS:  # Source: https://pinout.xyz/pinout/i2c
            sda, scl = gpio("SDA", 2, is_shared=True), gpio("SCL", 3, is_shared=True)
        else:
            sda, scl = (Connection(line, "I2C", f"{line} of bus {self.bus}", is_shared=True) for line in ("SDA", "SCL"))
        return sda, scl, Connection("address", "I2C", self.place)

    def open(self, description: RangeSensorDescription, host: Host) -> RangeSensor:
        lidar = Lidar(description, self, host.clock)
        lidar.open()
        return lidar


class VL53L0X(TimeOfFlight):
    """Opens ST's VL53L0X, whose range is 1.2 m."""

    name = "vl53l0x"
    summary = "VL53L0X: a laser's time of flight up to 1.2 m, on an I2C bus"
    modules = ("adafruit_vl53l0x", "adafruit_extended_bus")
    chip = VL53L0XChip


class VL53L1X(TimeOfFlight):
    """Opens ST's VL53L1X, whose range is 3.6 m."""

    name = "vl53l1x"
    summary = "VL53L1X: a laser's time of flight up to 3.6 m, on an I2C bus"
    modules = ("adafruit_vl53l1x", "adafruit_extended_bus")
    chip = VL53L1XChip


STALLED_S = 1.0
"""A chip without a new measurement for this many seconds has lost power, and must be set up again."""

_EXTRA_CYCLES = 20
"""Opening waits for the first sample for at most ``echo_free_cycles`` plus this many cycles."""

_LIBRARY_LOCK = threading.Lock()
"""Lets only one thread at a time call Adafruit's libraries, because all their sensors share one buffer."""


class Lidar(SampledRangeSensor):
    """A range sensor that reads its chip once in each cycle, and sets the chip up again after a failure.

    A sample has the time of the previous read of the chip, because its measurement began at most 50 ms before that
    read.
    """

    def __init__(self, description: RangeSensorDescription, settings: TimeOfFlight, clock: Clock) -> None:
        super().__init__(description, RangeSampler(description, settings.echo_free_cycles))
        self._settings, self._clock = settings, clock
        self._chip: LightChip | None = None
        self._read_at = self._measured_at = 0.0

    def _start(self) -> None:
        self._read_at = self._clock.now()
        self._opened.callback(self._disconnect)
        never, cycle_s = threading.Event(), self._settings.cycle_s
        self._take_first(self._poll, lambda: never.wait(cycle_s), self._settings.echo_free_cycles + _EXTRA_CYCLES)
        self._opened.callback(self._clock.every(cycle_s, self._poll, self.name).stop)

    def _poll(self) -> None:
        try:
            self._read_chip()
        except DeviceError as error:
            self._disconnect()
            self._sampler.fail(error)

    def _read_chip(self) -> None:
        before, self._read_at = self._read_at, self._clock.now()
        if self._chip is None:
            self._chip, self._measured_at = self._connect(), self._read_at
        with self._translate_errors():
            measurement = self._chip.measure()
        if measurement is not None:
            self._measured_at = self._read_at
            self._add_measurement(*measurement, before)
        elif self._read_at - self._measured_at > STALLED_S:
            raise DeviceError(self.name, "has stopped measuring. Check its 3.3 V", kind="chip-stalled")

    def _add_measurement(self, status: Status | None, distance: float, time: float) -> None:
        if status == "broken":
            message = "reports a broken laser. Switch its 3.3 V off and on, or replace it"
            raise DeviceError(self.name, message, kind="laser-broken")
        self._sampler.clear_failure()
        if status in ("target", "too near", "beyond"):
            self._sampler.add_distance({"too near": 0.0, "beyond": math.inf}.get(status, distance), time)
        elif status == "no light":
            self._sampler.add_no_echo(time)
        else:
            self._sampler.add_unclear()

    def _connect(self) -> LightChip:
        with self._translate_errors(), ExitStack() as undo:
            from adafruit_extended_bus import ExtendedI2C

            bus = ExtendedI2C(self._settings.bus, frequency=None)  # Linux sets the frequency at boot
            undo.callback(bus.deinit)
            chip = self._settings.chip(bus, self._settings.address, self.max_range)
            self._bus = undo.pop_all()
        return chip

    def _disconnect(self) -> None:
        """Stop the laser, if the chip still answers, and close the bus."""
        chip, self._chip = self._chip, None
        if chip is not None:
            with self._bus, suppress(DeviceError), self._translate_errors():
                chip.stop()

    @contextmanager
    def _translate_errors(self) -> Iterator[None]:
        try:
            with _LIBRARY_LOCK:
                yield
        except ImportError as error:
            message = f"its library is not installed ({error}); pip install 'robotcore[tof]'"
            raise DeviceError(self.name, message, kind="library-missing") from error
        except Exception as error:
            message = (
                f"no answer at I2C {self._settings.place} ({error}). Switch I2C on (raspi-config). Check SDA, SCL, "
                "3.3 V, ground, and the chip's name in the robot's file"
            )
            raise DeviceError(self.name, message, kind="chip-unanswered") from error
