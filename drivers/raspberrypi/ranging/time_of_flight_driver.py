"""The drivers of ST's VL53L0X and VL53L1X, range sensors that measure a laser's time of flight, on an I2C bus."""

from __future__ import annotations

import math
import threading
from abc import abstractmethod
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from drivers.raspberrypi.i2c import Address, ChipDriver, TransactionLimit
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hardware import DeviceContext, Drivers, PolledRangeSensor
from robotcore.hardware.polled_samples import RangeSampler, require_timely
from robotcore.kinds.range_sensor import RangeSensor, RangeSensorDescription

Status = Literal["target", "too near", "beyond", "no light", "broken"]
"""The status that a chip reports with a measurement.

Only the distance of a "target" is valid. "no light" means that too little light came back: there is no target, or a
dark target. "broken" means that the chip's own check of its laser failed.
"""


class TimeOfFlight(ChipDriver):
    """The base class of the drivers of both chips. A chip measures continuously after `begin`.

    A distance is `inf` if the chip reports a target beyond its range, or after ``echo_free_cycles`` measurements with
    too little light. A single measurement with too little light makes no sample, because the target may be dark.

    `begin`, `clear` and `stop` raise the errors of Adafruit's libraries.
    """

    described = RangeSensorDescription
    extra = "tof"
    lock = threading.Lock()
    remedy = "On the Pi: pip install 'robotcore[tof]'"

    reach: ClassVar[float]
    """The longest distance that the chip can measure, in metres."""
    result: ClassVar[bytes]
    """The register with the status."""
    distance_at: ClassVar[int]
    """The number of bytes from the status to the distance in mm, whose high byte is the first one."""
    status_bits: ClassVar[tuple[int, int]]
    """The mask of the status in its register, and the number of bits below it."""
    statuses: ClassVar[Mapping[int, Status]]

    address: Address = 0x29
    """The 7-bit address of the chip on the bus."""

    cycle_s: Annotated[float, Field(ge=0.02, le=1)] = 0.05
    """The time between two reads of the chip, in seconds."""

    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] = 10
    """After this many cycles in a row with too little light, the sample is `inf`. With 0, a cycle with too little
    light never makes a sample."""

    def check(self, description: RangeSensorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if description.max_range_m > self.reach:
            raise ValueError(
                f"the range of a {self.name.upper()} is {self.reach:g} m, but max_range_m is "
                f"{description.max_range_m:g}; lower it"
            )
        require_timely(self.echo_free_cycles, self.cycle_s, robot)

    def open(self, description: RangeSensorDescription, context: DeviceContext) -> RangeSensor:
        lidar = Lidar(description, self, context.clock)
        lidar.open()
        return lidar

    @abstractmethod
    def begin(self, bus: Any, max_range: float) -> Any:
        """Start measuring, and return the library's object for the chip. ``max_range`` is in metres."""

    @abstractmethod
    def clear(self, library: Any) -> None:
        """Let the chip store the next measurement."""

    @abstractmethod
    def stop(self, library: Any) -> None:
        """Stop measuring."""


class VL53L0X(TimeOfFlight):
    """Opens ST's VL53L0X, whose range is 1.2 m. A measurement takes 33 ms.

    Source: ST's API (STSW-IMG005), VL53L0X_DEVICEERROR_…, VL53L0X_get_pal_range_status and GetRangingMeasurementData.
    """

    name = "vl53l0x"
    summary = "VL53L0X: a laser's time of flight up to 1.2 m, on an I2C bus"
    modules = ("adafruit_vl53l0x", "adafruit_extended_bus")
    reach = 1.2
    result, distance_at, status_bits = b"\x14", 10, (0x78, 3)
    statuses: ClassVar[Mapping[int, Status]] = {
        **dict.fromkeys((1, 2, 3), "broken"),
        4: "no light",
        **dict.fromkeys((6, 9), "beyond"),
        10: "too near",
        11: "target",
    }

    def begin(self, bus: Any, max_range: float) -> Any:
        import adafruit_vl53l0x

        library = adafruit_vl53l0x.VL53L0X(bus, self.address, io_timeout_s=1.0)
        library.start_continuous()
        return library

    def clear(self, library: Any) -> None:
        library.read_range()

    def stop(self, library: Any) -> None:
        library.stop_continuous()


_SHORT_REACH_M = 1.3
"""The range of a VL53L1X in its short mode, which daylight disturbs less, in metres."""

_FIRST_TRANSACTIONS = 300
"""The maximum number of transactions until a VL53L1X's first measurement. The set-up takes 40. Then the library
requests a measurement every 10 ms, by two transactions."""


class VL53L1X(TimeOfFlight):
    """Opens ST's VL53L1X, whose range is 3.6 m. A measurement takes 50 ms.

    Source: ST's ultra lite driver (STSW-IMG009), VL53L1X_GetRangeStatus and VL53L1X_GetResult, and its manual, UM2510.
    """

    name = "vl53l1x"
    summary = "VL53L1X: a laser's time of flight up to 3.6 m, on an I2C bus"
    modules = ("adafruit_vl53l1x", "adafruit_extended_bus")
    reach = 3.6
    result, distance_at, status_bits = b"\x00\x89", 13, (0x1F, 0)
    statuses: ClassVar[Mapping[int, Status]] = {
        **dict.fromkeys((1, 2, 3), "broken"),
        4: "no light",
        **dict.fromkeys((5, 7), "beyond"),
        8: "too near",
        9: "target",
    }

    def begin(self, bus: Any, max_range: float) -> Any:
        import adafruit_vl53l1x

        limit = TransactionLimit(bus, _FIRST_TRANSACTIONS)
        library = adafruit_vl53l1x.VL53L1X(limit, self.address)
        limit.left = math.inf
        library.distance_mode = 1 if max_range <= _SHORT_REACH_M else 2
        library.start_ranging()
        return library

    def clear(self, library: Any) -> None:
        library.clear_interrupt()

    def stop(self, library: Any) -> None:
        library.stop_ranging()


STALLED_S = 1.0
"""A chip without a new measurement for this many seconds has lost power, and must be set up again."""

_EXTRA_CYCLES = 20
"""Opening waits for the first sample for at most ``echo_free_cycles`` plus this many cycles."""


class Lidar(PolledRangeSensor):
    """A range sensor that reads its chip once in each cycle, and sets the chip up again after a failure.

    A sample has the time of the previous read of the chip, because its measurement began at most 50 ms before that
    read.
    """

    def __init__(self, description: RangeSensorDescription, settings: TimeOfFlight, clock: Clock) -> None:
        super().__init__(description, RangeSampler(description, settings.echo_free_cycles))
        self._settings, self._clock = settings, clock
        self._library: Any = None
        self._read_at = self._measured_at = 0.0

    def _start(self) -> None:
        self._read_at = self._clock.now()
        self._opened.callback(self._disconnect)
        never, cycle_s = threading.Event(), self._settings.cycle_s
        self._take_first(self._poll, lambda: never.wait(cycle_s), self._settings.echo_free_cycles + _EXTRA_CYCLES)
        self._opened.callback(self._clock.call_every(cycle_s, self._poll, self.name).stop)

    def _poll(self) -> None:
        try:
            self._read_chip()
        except DeviceError as error:
            self._disconnect()
            self._sampler.fail(error)

    def _read_chip(self) -> None:
        before, self._read_at = self._read_at, self._clock.now()
        if self._library is None:
            self._connect()
            self._measured_at = self._read_at
        with self._settings.translate_errors(self.name):
            measurement = self._measure()
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

    def _measure(self) -> tuple[Status | None, float] | None:
        """Return the status and the distance in metres; None without a new measurement since the last call.

        The status is None if the chip reports no valid result. Status and distance are read in one transaction, so that
        they belong to the same measurement. Adafruit's libraries do not do this.
        """
        chip, library = self._settings, self._library
        if not library.data_ready:
            return None
        result = bytearray(chip.distance_at + 2)
        with self._registers as registers:
            registers.write(chip.result)
            registers.readinto(result)
        chip.clear(library)
        mask, shift = chip.status_bits
        return chip.statuses.get((result[0] & mask) >> shift), int.from_bytes(result[chip.distance_at :], "big") / 1000

    def _connect(self) -> None:
        with self._settings.translate_errors(self.name), ExitStack() as undo:
            from adafruit_bus_device.i2c_device import I2CDevice

            bus = self._settings.open_bus(undo)
            self._registers = I2CDevice(bus, self._settings.address)
            self._library = self._settings.begin(bus, self.max_range)
            self._bus = undo.pop_all()

    def _disconnect(self) -> None:
        """Stop the laser, if the chip still answers, and close the bus."""
        library, self._library = self._library, None
        if library is not None:
            with self._bus, suppress(DeviceError), self._settings.translate_errors(self.name):
                self._settings.stop(library)
