"""The lidars on a serial line, and the conversion of their revolutions to scans."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.serial.driver import SerialDriver
from drivers.serial.line import Line
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hardware import Drivers, NewestSample
from robotcore.kinds.lidar import Lidar, LidarDescription, Scan

Array = NDArray[np.float64]

MAX_GAP_RAD = math.radians(5)
"""The largest angle between two neighbouring measurements of a revolution that makes a scan, in radians.

Lidars measure every 0.5° to 2°. A larger gap means lost data.
"""

NO_SCAN = "has no complete revolution yet. Check that the lidar turns freely, and that nothing else reads its port"
"""The problem in the error of a lidar without a scan."""


class ScanBuilder:
    """Converts the measurements of each revolution to a scan, and stores the newest scan in ``newest``.

    A ray has the shortest distance that was measured within half a step of its bearing, or else the nearest
    measurement. A revolution with a gap makes no scan.
    """

    def __init__(self, lidar: LidarDescription) -> None:
        missing = DeviceError(lidar.name, NO_SCAN, kind="no-sample-yet")
        self.newest: NewestSample[Scan] = NewestSample(lidar.name, missing)
        self.has_scan = False
        """Whether there has been a scan."""
        self._lidar, self._sequence = lidar, 0
        self._half = (lidar.end_rad - lidar.start_rad) / 2
        self._bearings = np.array(lidar.bearings) - lidar.start_rad - self._half
        self._step = self._bearings[1] - self._bearings[0]

    def add_revolution(self, angles: Array, distances: Array, time: float) -> None:
        """Add the measurements of a revolution.

        angles: the angles from the lidar's direction, in degrees, positive to the right.
        distances: the distances in metres, ``inf`` without an echo.
        time: the time of the first measurement on the robot's clock, in seconds.
        """
        lidar = self._lidar
        is_echo = (distances >= lidar.min_range_m) & (distances <= lidar.max_range_m)
        distances = np.where(is_echo, distances, math.inf)
        middle = lidar.start_rad + self._half
        # The angles of all following lines are relative to the middle of the field of view, from -π to π.
        measured = np.mod(-np.radians(angles) - middle + math.pi, math.tau) - math.pi
        order = np.argsort(measured)
        measured, distances = measured[order], distances[order]
        around = np.concatenate((measured - math.tau, measured, measured + math.tau))
        seen = np.clip(around, -self._half, self._half)
        if np.diff(seen, prepend=-self._half, append=self._half).max() > MAX_GAP_RAD:
            return
        rays = np.rint((measured + self._half) / self._step).astype(int)
        if lidar.is_full_circle:
            rays %= lidar.count
        is_inside = (rays >= 0) & (rays < lidar.count)
        scan, is_filled = np.full(lidar.count, math.inf), np.zeros(lidar.count, dtype=bool)
        np.minimum.at(scan, rays[is_inside], distances[is_inside])
        is_filled[rays[is_inside]] = True
        for ray in np.flatnonzero(~is_filled):
            scan[ray] = distances[np.abs(around - self._bearings[ray]).argmin() % len(distances)]
        self.newest.put(Scan(tuple(scan.tolist()), time, self._sequence))
        self._sequence += 1
        self.has_scan = True


class SerialLidar(Lidar):
    """A lidar, alone on its line. Reading it raises DeviceLostError while the line is lost."""

    def __init__(self, lidar: LidarDescription, builder: ScanBuilder, line: Line) -> None:
        super().__init__(lidar.name, **lidar.arguments())
        self._builder, self._line = builder, line

    def open(self, answer_s: float, first_s: float) -> None:
        """Open the line, and wait for the first scan. Raises DeviceError if there is no answer, or no scan.

        answer_s: the longest wait for the first data, in seconds.
        first_s: the longest wait for the first scan after that, in seconds.
        """
        try:
            self._line.open(self.name, answer_s)
            self._line.wait_until(lambda: self._builder.has_scan, self.name, first_s, lambda: NO_SCAN)
            self._newest()
        except BaseException:
            self.close()
            raise

    def _newest(self) -> Scan:
        self._line.require(self.name)
        newest = self._builder.newest.get()
        self._line.require_since_lost(self.name, newest.time)
        return newest

    def _release(self) -> None:
        self._line.close()


MAX_RANGE_M = 12.0
"""The longest distance of an LD06 and of an RPLIDAR A1 in their manuals, in metres."""


class LidarDriver(SerialDriver):
    """The base class of the drivers of lidars."""

    described = LidarDescription

    def check(self, description: LidarDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if description.max_range_m > MAX_RANGE_M:
            limit = f"an {self.protocol_name} measures up to {MAX_RANGE_M:g} m"
            raise ValueError(f"{limit}, but max_range_m is {description.max_range_m:g}; lower it")
