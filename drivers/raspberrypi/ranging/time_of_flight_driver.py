"""The drivers of the VL53L0X and the VL53L1X, range sensors that measure a laser's time of flight, on an I2C bus."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Annotated, ClassVar

from pydantic import Field

from drivers.raspberrypi.header import gpio
from drivers.raspberrypi.ranging.time_of_flight_chips import (
    ChipAddress,
    I2CChip,
    LightChip,
    Measurement,
    RangeStatus,
    VL53L0XChip,
    VL53L1XChip,
)
from robotcore.description import RangeSensorDescription, RobotDescription, StrictModel
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hardware import Connection, DeviceDriver, Host
from robotcore.hardware.polled_samples import RangeSampler, require_timely

_HEADER_BUS, _SDA, _SCL = 1, 2, 3
"""The I2C bus of the header, and the GPIOs of its two lines. Source: https://pinout.xyz/pinout/i2c."""

_EXTRA_CYCLES = 20
"""Opening waits for the first sample for at most ``echo_free_cycles`` plus this many cycles."""


class TimeOfFlightSettings(StrictModel):
    """The settings of a time-of-flight sensor."""

    bus: Annotated[int, Field(ge=0, le=30)] = _HEADER_BUS
    """The number of the chip's I2C bus."""

    address: Annotated[int, Field(ge=0x08, le=0x77)] = 0x29
    """The 7-bit address of the chip on the bus."""

    cycle_s: Annotated[float, Field(ge=0.02, le=1)] = 0.05
    """The time between two reads of the chip, in seconds."""

    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] = 10
    """After this many cycles in a row with too little light, the sample is `inf`. With 0, a cycle with too little
    light never makes a sample."""


class TimeOfFlight(DeviceDriver[RangeSensorDescription, TimeOfFlightSettings]):
    """The base class of the drivers of both chips.

    A distance is `inf` if the chip reports a target beyond its range, or after ``echo_free_cycles`` measurements with
    too little light. A single measurement with too little light makes no sample, because the target may be dark.
    """

    described = RangeSensorDescription
    settings = TimeOfFlightSettings
    remedy = "On the Pi: pip install 'robotcore[tof]'"
    chip: ClassVar[type[LightChip]]

    def check(
        self, description: RangeSensorDescription, settings: TimeOfFlightSettings, robot: RobotDescription
    ) -> None:
        if description.max_range_m > self.chip.reach:
            raise ValueError(
                f"the range of a {self.name.upper()} is {self.chip.reach:g} m, but max_range_m is "
                f"{description.max_range_m:g}; lower it"
            )
        require_timely(settings.echo_free_cycles, settings.cycle_s, robot)

    def connections(self, settings: TimeOfFlightSettings) -> Sequence[Connection]:
        address = Connection("address", "I2C", f"0x{settings.address:02x} on bus {settings.bus}")
        if settings.bus != _HEADER_BUS:
            lines = (
                Connection(line, "I2C", f"{line} of bus {settings.bus}", is_shared=True) for line in ("SDA", "SCL")
            )
            return (*lines, address)
        return gpio("SDA", _SDA, is_shared=True), gpio("SCL", _SCL, is_shared=True), address

    def open(self, description: RangeSensorDescription, settings: TimeOfFlightSettings, host: Host) -> RangeSensor:
        chip_address = ChipAddress(description.name, settings.bus, settings.address)
        connect = partial(I2CChip, self.chip, chip_address, description.max_range_m)
        with ExitStack() as undo:
            lidar = Lidar(description, RangeSampler(description, settings.echo_free_cycles), connect, host.clock)
            undo.callback(lidar.close)
            lidar.start(settings.cycle_s, settings.echo_free_cycles + _EXTRA_CYCLES)
            undo.pop_all()
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


class Lidar(RangeSensor):
    """A range sensor that reads its chip once in each cycle, and sets the chip up again after a failure.

    A sample has the time of the previous read of the chip, because its measurement began at most 50 ms before that
    read.

    connect: opens the chip; raises DeviceError.
    """

    def __init__(
        self, description: RangeSensorDescription, sampler: RangeSampler, connect: Callable[[], I2CChip], clock: Clock
    ) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._sampler, self._connect, self._clock = sampler, connect, clock
        self._chip: I2CChip | None = None
        self._read_at = self._measured_at = 0.0
        self._stopping = ExitStack()

    def start(self, cycle_s: float, first_cycles: int) -> None:
        """Wait ``first_cycles`` cycles at most for the first sample, then start measuring; raises DeviceError."""
        self._read_at = self._clock.now()
        self._stopping.callback(self._disconnect)
        never = threading.Event()
        for _ in range(first_cycles):
            self._poll()
            if self._sampler.has_result:
                break
            never.wait(cycle_s)
        self._newest()
        self._stopping.callback(self._clock.every(cycle_s, self._poll, self.name).stop)

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
        measurement = self._chip.measure()
        if measurement is not None:
            self._measured_at = self._read_at
            self._classify(measurement, before)
        elif self._read_at - self._measured_at > STALLED_S:
            raise DeviceError(self.name, "has stopped measuring. Check its 3.3 V", kind="chip-stalled")

    def _classify(self, measurement: Measurement, time: float) -> None:
        if measurement.status is RangeStatus.BROKEN:
            raise DeviceError(
                self.name,
                "reports a broken laser. Switch its 3.3 V off and on, or replace it",
                kind="laser-broken",
            )
        self._sampler.clear_failure()
        match measurement.status:
            case RangeStatus.TARGET:
                self._sampler.add_distance(measurement.distance, time)
            case RangeStatus.TOO_NEAR:
                self._sampler.add_distance(0.0, time)
            case RangeStatus.BEYOND:
                self._sampler.add_distance(math.inf, time)
            case RangeStatus.NOTHING:
                self._sampler.add_no_echo(time)
            case _:
                self._sampler.add_unclear()

    def _disconnect(self) -> None:
        chip, self._chip = self._chip, None
        if chip is not None:
            chip.close()

    def _newest(self) -> Range:
        return self._sampler.newest.get()

    def _release(self) -> None:
        self._stopping.close()
