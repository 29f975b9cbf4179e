"""VL53L0X and VL53L1X: a laser's time of flight, measured by a chip on an I2C bus."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from typing import Annotated, ClassVar

from pydantic import Field

from drivers.raspberrypi.gpio import gpio
from drivers.raspberrypi.ranging.i2c import I2CChip, Place
from drivers.raspberrypi.ranging.lidar import Lidar
from drivers.raspberrypi.ranging.lightchips import LightChip, VL53L0XChip, VL53L1XChip
from robotcore.description import RangeSensorDescription, RobotDescription, StrictModel
from robotcore.hal.devices import RangeSensor
from robotcore.hardware import Connection, DeviceDriver, Host
from robotcore.hardware.polled import Findings, require_timely

_HEADER_BUS, _SDA, _SCL = 1, 2, 3
"""Source: https://pinout.xyz/pinout/i2c."""

_MORE_CYCLES = 20
"""What the first measurement may take beside a row of those that find nothing."""


class TimeOfFlightSettings(StrictModel):
    """The number of its bus and its address there, how often it is asked, and how it is judged.

    So many ``echo_free_cycles`` in a row, in which too little light came back, vouch for nothing in range; 0: none do.
    """

    bus: Annotated[int, Field(ge=0, le=30)] = _HEADER_BUS
    address: Annotated[int, Field(ge=0x08, le=0x77)] = 0x29
    cycle_s: Annotated[float, Field(ge=0.02, le=1)] = 0.05
    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] = 10


class TimeOfFlight(DeviceDriver[RangeSensorDescription, TimeOfFlightSettings]):
    """What both chips have in common.

    `inf` is what the chip itself calls farther than it can measure, or a row of measurements in which too little light
    came back; a single one of these, as from something dark, is no new sample.
    """

    described = RangeSensorDescription
    settings = TimeOfFlightSettings
    remedy = "On the Pi: pip install 'robotcore[tof]'"
    chip: ClassVar[type[LightChip]]

    def check(self, told: RangeSensorDescription, settings: TimeOfFlightSettings, robot: RobotDescription) -> None:
        if told.max_range_m > self.chip.reach:
            raise ValueError(
                f"a {self.name.upper()} sees as far as {self.chip.reach:g} m, and max_range_m is {told.max_range_m:g}; "
                "lower it"
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

    def open(self, told: RangeSensorDescription, settings: TimeOfFlightSettings, host: Host) -> RangeSensor:
        place = Place(told.name, settings.bus, settings.address)
        connect = partial(I2CChip, self.chip, place, told.max_range_m)
        with ExitStack() as undo:
            lidar = Lidar(told, Findings(told, settings.echo_free_cycles), connect, host.clock)
            undo.callback(lidar.close)
            lidar.start(settings.cycle_s, settings.echo_free_cycles + _MORE_CYCLES)
            undo.pop_all()
        return lidar


class VL53L0X(TimeOfFlight):
    """ST's VL53L0X, up to 1.2 m."""

    name = "vl53l0x"
    summary = "VL53L0X: a laser's time of flight up to 1.2 m, on an I2C bus"
    modules = ("adafruit_vl53l0x", "adafruit_extended_bus")
    chip = VL53L0XChip


class VL53L1X(TimeOfFlight):
    """ST's VL53L1X, up to 3.6 m."""

    name = "vl53l1x"
    summary = "VL53L1X: a laser's time of flight up to 3.6 m, on an I2C bus"
    modules = ("adafruit_vl53l1x", "adafruit_extended_bus")
    chip = VL53L1XChip
