"""The driver of Bosch's BNO055, an IMU on an I2C bus that computes its heading by itself.

Source: the data sheet BST-BNO055-DS000, https://www.bosch-sensortec.com/products/smart-sensor-systems/bno055/.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.header import HEADER_BUS
from drivers.raspberrypi.i2c import Address
from drivers.raspberrypi.polled_imu import TURNS, ImuDriver, Motion, PolledImu
from robotcore.errors import DeviceError
from robotcore.geometry import wrap_angle
from robotcore.hal.clock import Clock
from robotcore.hardware import DeviceContext
from robotcore.kinds.imu import Imu, ImuDescription

CLOCK_STRETCHING_NOTE = (
    "The I2C hardware of a Pi up to 4 misreads this chip at times, because the chip stretches the clock. Use a bus of "
    "the kernel's driver i2c-gpio: https://learn.adafruit.com/raspberry-pi-i2c-clock-stretching-fixes"
)
"""The note for a chip on the I2C bus of the header."""

CALIBRATED = 3
"""The status of a sensor of the chip that is fully calibrated."""

CHECK_S = 0.05
"""The time between two looks at the status while a run waits for the calibration, in seconds."""

MAX_RATE_RAD_S, MAX_ACCELERATION_M_S2 = 35.0, 80.0
"""Greater values are misread: the chip's ranges are 2000 °/s and 4 g."""

MAX_JUMP_RAD, MAX_DRIFT_RAD_S = 0.1, 1.0
"""A heading is misread if it differs by more than this from the last one, turned on by the turn rate.

The second number is multiplied by the time since the last heading, because the turn rate may have changed meanwhile.
"""

ATTEMPTS = 3
"""The number of successive reads of which one must be plausible."""


class BNO055(ImuDriver):
    """Opens Bosch's BNO055. It waits until the chip has calibrated its gyroscope, for which the robot must stand."""

    name = "bno055"
    summary = "BNO055: turn rate, acceleration and heading, on an I2C bus"
    aliases = ("bno-055",)
    modules = ("adafruit_bno055", "adafruit_extended_bus")
    lock = threading.Lock()

    address: Address = 0x28
    """The 7-bit address of the chip on the bus: 0x28, or 0x29 if its pin ADR is at 3.3 V."""

    cycle_s: Annotated[float, Field(ge=0.01, le=0.1)] = 0.02
    """The time between two reads of the chip, in seconds. It measures every 10 ms."""

    calibration_s: Annotated[float, Field(gt=0, le=60)] = 10.0
    """The longest wait for the calibration of the gyroscope at the opening, in seconds."""

    def notes(self, description: ImuDescription) -> Sequence[str]:
        still = "Keep the robot still when a run begins, until the chip has calibrated its gyroscope."
        return (*super().notes(description), still, *([CLOCK_STRETCHING_NOTE] if self.bus == HEADER_BUS else []))

    def open(self, description: ImuDescription, context: DeviceContext) -> Imu:
        imu = FusionImu(description.name, self, context.clock)
        imu.open()
        return imu

    def begin(self, bus: Any) -> Any:
        import adafruit_bno055

        library = adafruit_bno055.BNO055_I2C(bus, self.address)
        library.axis_remap = self.axis_remap
        # Without the magnetometer, which motors disturb.
        library.mode = adafruit_bno055.IMUPLUS_MODE
        return library

    @property
    def axis_remap(self) -> tuple[int, ...]:
        """The chip's axis (0 for x) on each axis of the robot, and for each of them 1 if the axis is reversed."""
        along_x, along_y = TURNS[self.forward_axis]
        up = -1 if self.is_upside_down else 1
        forward, left = along_x + along_y, up * (along_x - along_y)
        return (0, 1, 2, forward < 0, left < 0, up < 0) if along_x else (1, 0, 2, forward < 0, left < 0, up < 0)


class FusionImu(PolledImu):
    """An IMU whose chip computes the heading. It misses the turns during a failure."""

    transient = frozenset({"not-calibrated", "chip-misread"})

    def __init__(self, name: str, settings: BNO055, clock: Clock) -> None:
        super().__init__(name, settings, clock)
        self._settings = settings
        self._heading = self._zero = self._read_at = self._rate = 0.0
        self._is_calibrated = False

    def _prepare(self) -> None:
        timer = threading.Event()
        for _ in range(math.ceil(self._settings.calibration_s / CHECK_S)):
            if self._read_status() == CALIBRATED:
                return
            timer.wait(CHECK_S)
        waited = f"within {self._settings.calibration_s:g} s"
        raise self._build_calibration_error(waited)

    def _read_status(self) -> int:
        library = self._connect()
        with self._settings.translate_errors(self.name):
            return int(library.calibration_status[1])

    def _measure(self, now: float) -> tuple[Motion, float]:
        self._connect()
        if not self._is_calibrated:
            if self._read_status() != CALIBRATED:
                raise self._build_calibration_error("since it was connected again")
            _, angle = self._read_chip()
            self._is_calibrated, self._read_at, self._rate = True, now, 0.0
            self._zero = angle - self._heading
        for _ in range(ATTEMPTS):
            motion, angle = self._read_chip()
            heading = wrap_angle(angle - self._zero)
            if self._is_plausible(motion, heading, now - self._read_at):
                self._heading, self._read_at, self._rate = heading, now, motion.yaw_rate
                return motion, heading
        remedy = (
            CLOCK_STRETCHING_NOTE
            if self._settings.bus == HEADER_BUS
            else "Check SDA, SCL and their pull-ups, and 3.3 V"
        )
        raise DeviceError(self.name, f"was misread {ATTEMPTS} times in a row. {remedy}", kind="chip-misread")

    def _is_plausible(self, motion: Motion, heading: float, passed: float) -> bool:
        """Return whether values are in the chip's range, and agree with the last ones ``passed`` seconds ago."""
        expected = self._heading + (self._rate + motion.yaw_rate) / 2 * passed
        is_continuous = abs(wrap_angle(heading - expected)) <= MAX_JUMP_RAD + MAX_DRIFT_RAD_S * passed
        is_in_range = abs(motion.yaw_rate) < MAX_RATE_RAD_S and max(map(abs, motion[1:])) < MAX_ACCELERATION_M_S2
        return is_continuous and is_in_range

    def _read_chip(self) -> tuple[Motion, float]:
        """Return the motion, and the chip's angle to the left in radians."""
        with self._settings.translate_errors(self.name):
            rates, accelerations, angles = self._library.gyro, self._library.linear_acceleration, self._library.euler
        if None in (*rates, *accelerations, *angles):
            raise DeviceError(self.name, "has lost its settings. Check its 3.3 V", kind="chip-reset")
        return Motion(rates[2], *accelerations[:2]), -math.radians(angles[0])  # the chip counts to the right

    def _build_calibration_error(self, since: str) -> DeviceError:
        message = f"has not calibrated its gyroscope {since}. Let the robot stand for a few seconds"
        return DeviceError(self.name, message, kind="not-calibrated")

    def _disconnect(self) -> None:
        self._is_calibrated = False
        super()._disconnect()
