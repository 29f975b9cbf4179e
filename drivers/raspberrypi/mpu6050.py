"""The driver of InvenSense's MPU-6050, a gyroscope and accelerometer on an I2C bus."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from operator import gt
from statistics import fmean
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.i2c import Address, TransactionLimit
from drivers.raspberrypi.polled_imu import TURNS, ImuDriver, Motion, PolledImu
from robotcore.errors import DeviceError
from robotcore.geometry import wrap_angle
from robotcore.hal.clock import Clock
from robotcore.hardware import DeviceContext
from robotcore.kinds.imu import Imu, ImuDescription


class MPU6050(ImuDriver):
    """Opens InvenSense's MPU-6050. While the robot stands at the opening, its zero offsets are measured."""

    name = "mpu6050"
    summary = "MPU-6050: turn rate and acceleration, on an I2C bus"
    aliases = ("mpu-6050", "gy-521")
    modules = ("adafruit_mpu6050", "adafruit_extended_bus")
    lock = threading.Lock()

    address: Address = 0x68
    """The 7-bit address of the chip on the bus: 0x68, or 0x69 if its pin AD0 is at 3.3 V."""

    bias_s: Annotated[float, Field(ge=0, le=30)] = 1.0
    """The time for which opening measures the zero offsets, in seconds. The robot must stand. With 0, the offsets are
    0."""

    def notes(self, description: ImuDescription) -> Sequence[str]:
        still = [f"Keep the robot still for {self.bias_s:g} s when a run begins."] if self.bias_s else []
        return (*super().notes(description), *still)

    def open(self, description: ImuDescription, context: DeviceContext) -> Imu:
        imu = IntegratingImu(description.name, self, context.clock)
        imu.open()
        return imu

    def begin(self, bus: Any) -> Any:
        """Set the chip up, and return the library's object for it."""
        import adafruit_mpu6050

        limit = TransactionLimit(bus, _FIRST_TRANSACTIONS)
        library = adafruit_mpu6050.MPU6050(limit, self.address)
        limit.left = math.inf
        library.filter_bandwidth = adafruit_mpu6050.Bandwidth.BAND_44_HZ
        return library

    def to_robot_frame(self, rates: Sequence[float], accelerations: Sequence[float]) -> Motion:
        """Convert the values of the chip's axes to the robot's frame."""
        along_x, along_y = TURNS[self.forward_axis]
        x, y, _ = accelerations
        up = -1 if self.is_upside_down else 1
        return Motion(up * rates[2], along_x * x + along_y * y, up * (along_x * y - along_y * x))


_FIRST_TRANSACTIONS = 300
"""The maximum number of transactions of the chip's set-up. It takes about 30. Then the library waits for the reset of
the chip without a time limit, with a transaction every millisecond."""

_MAX_SPREAD = Motion(0.1, 1.0, 1.0)
"""If two measurements of a robot differ by more than this, it moves."""

_MAX_OFFSET_RAD_S = 0.4
"""A greater mean of the turn rates is a turn of the robot, in rad/s. The data sheet has a zero offset of up to 20 °/s:
https://invensense.tdk.com/wp-content/uploads/2015/02/MPU-6000-Datasheet1.pdf"""


class IntegratingImu(PolledImu):
    """An IMU whose heading is the integral of the turn rate at each read. It misses the turns during a failure."""

    def __init__(self, name: str, settings: MPU6050, clock: Clock) -> None:
        super().__init__(name, settings, clock)
        self._settings = settings
        self._offset = Motion(0.0, 0.0, 0.0)
        self._heading = 0.0
        self._last: tuple[float, float] | None = None

    def _prepare(self) -> None:
        never, cycle_s = threading.Event(), self._settings.cycle_s
        measured = []
        for _ in range(round(self._settings.bias_s / cycle_s)):
            measured.append(self._read_chip())
            never.wait(cycle_s)
        if not measured:
            return
        fields = list(zip(*measured, strict=True))
        self._offset = Motion(*map(fmean, fields))
        spread = Motion(*(max(field) - min(field) for field in fields))
        if any(map(gt, spread, _MAX_SPREAD)) or abs(self._offset.yaw_rate) > _MAX_OFFSET_RAD_S:
            change = max(spread.forward, spread.left)
            message = (
                f"the robot moves: its turn rate is {self._offset.yaw_rate:.2f} rad/s and changes by "
                f"{spread.yaw_rate:.2f} rad/s, its acceleration changes by {change:.2f} m/s². Let it stand when a run "
                "begins"
            )
            raise DeviceError(self.name, message, kind="not-at-rest")

    def _measure(self, now: float) -> tuple[Motion, float]:
        measured, offset = self._read_chip(), self._offset
        rate = measured.yaw_rate - offset.yaw_rate
        if self._last:
            time, before = self._last
            self._heading = wrap_angle(self._heading + (before + rate) / 2 * (now - time))
        self._last = now, rate
        return Motion(rate, measured.forward - offset.forward, measured.left - offset.left), self._heading

    def _read_chip(self) -> Motion:
        library = self._connect()
        with self._settings.translate_errors(self.name):
            accelerations, rates = library.acceleration, library.gyro
        if not any(accelerations):  # gravity is always measured
            message = "has lost its settings, and measures nothing. Check its 3.3 V"
            raise DeviceError(self.name, message, kind="chip-reset")
        return self._settings.to_robot_frame(rates, accelerations)

    def _disconnect(self) -> None:
        self._last = None
        super()._disconnect()
