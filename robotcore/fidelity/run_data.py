"""The measurements of a run at its ticks, either recorded or simulated: path, wheel angles, ranges and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.description import RobotDescription
from robotcore.geometry import Pose
from robotcore.hal.device import list_values
from robotcore.hal.kind import load_kind
from robotcore.optics import Image

Array = NDArray[np.float64]

SIDES = ("left", "right")

MAX_DISTANCES = 10_000_000
"""The maximum number of distances of a sensor that are compared, to limit the memory."""

PICTURE_WIDTH_PX = 80
"""The width of the grey pictures that are compared, in pixels."""


@dataclass(frozen=True, eq=False)
class AngleSeries:
    """The measured angles of the wheels on one side."""

    times: Array
    """The times of the measurements in seconds since the first tick, in ascending order, of shape (n,)."""
    angles: Array
    """The angles in radians, of shape (n,). The first one may be any angle."""

    @classmethod
    def mean(cls, encoders: Sequence[AngleSeries]) -> AngleSeries:
        """Return the mean of several encoders at the times of the first one."""
        times = encoders[0].times
        return cls(times, np.mean([np.interp(times, each.times, each.angles) for each in encoders], axis=0))


@dataclass(eq=False)
class RangeSeries:
    """The new samples of a sensor with rays."""

    distances: dict[int, Array] = field(default_factory=dict)
    """The distances in metres, one for each ray, by the index of the tick; ``inf`` for no echo."""
    times: list[float] = field(default_factory=list)
    """The capture time of each sample in seconds."""
    reads: list[int] = field(default_factory=list)
    """The indices of the ticks in which the sensor was read, also without a new sample."""
    _count: int = 0

    def add(self, tick: int, distances: Array, time: float) -> None:
        """Add a sample that was read in a tick. After `MAX_DISTANCES` distances, further samples are left out."""
        self._count += len(distances)
        if self._count <= MAX_DISTANCES:
            self.distances[tick] = distances
            self.times.append(time)

    @property
    def lost_share(self) -> float | None:
        """The share of echoes that gave no distance, from 0 to 1: missing samples, and rays without an echo.

        The median time between two samples is taken for the sensor's period. None without a sample.
        """
        if not self.times:
            return None
        received = sum(float(np.isfinite(each).mean()) for each in self.distances.values())
        periods = np.diff(self.times)
        median = float(np.median(periods)) if len(periods) else 0.0
        expected = round((self.times[-1] - self.times[0]) / median) + 1 if median > 0 else 0
        return 1 - received / max(expected, len(self.times))


@dataclass(eq=False)
class PictureSeries:
    """Small grey pictures of a camera."""

    width_px: int
    """The width of the camera's pictures, in pixels."""
    pictures: dict[int, Array] = field(default_factory=dict)
    """The pictures in grey levels from 0 to 255, by the index of the tick."""

    def add(self, tick: int, image: Image) -> None:
        """Add the picture that was read in a tick."""
        self.pictures[tick] = shrink(image)


def shrink(image: Image) -> Array:
    """Return a picture in grey, `PICTURE_WIDTH_PX` pixels wide."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    height = max(2, round(PICTURE_WIDTH_PX * image.shape[0] / image.shape[1]))
    return np.asarray(cv2.resize(grey, (PICTURE_WIDTH_PX, height), interpolation=cv2.INTER_AREA), float)


@dataclass(eq=False)
class RunData:
    """The measurements of one run. The index of a tick is its place among the ticks of the recording."""

    times: Array
    """The time of each tick in seconds since the first tick, of shape (n,)."""
    poses: Array
    """The pose at each tick, of shape (n, 3): x and y in metres, the heading in radians. NaN if it is unknown.

    The heading counts turns.
    """
    angles: dict[str, AngleSeries] = field(default_factory=dict)
    """The measured angles of the wheels, by the side of `SIDES`. Empty without encoders."""
    ranges: dict[str, RangeSeries] = field(default_factory=dict)
    """The samples of sensors with rays, by their names in the recording."""
    pictures: dict[str, PictureSeries] = field(default_factory=dict)
    """The pictures of cameras, by their names in the recording."""
    contacts: int | None = None
    """The number of contacts during the run; None if it is unknown."""

    @cached_property
    def start(self) -> Pose | None:
        """The first known pose; None if none is known."""
        known = self.poses[~np.isnan(self.poses[:, 0])]
        return Pose(*map(float, known[0])) if len(known) else None

    @property
    def sensors(self) -> set[str]:
        """The names of the sensors with samples."""
        return {*self.ranges, *self.pictures}

    @property
    def length_m(self) -> float:
        """The length of the path in metres."""
        known = self.poses[~np.isnan(self.poses[:, 0]), :2]
        return float(np.hypot(*np.diff(known, axis=0).T).sum())


def unwrap(poses: Iterable[Pose | None]) -> Array:
    """Return poses as an array, of shape (n, 3), with headings that count turns. A missing pose is NaN."""
    array = np.array([pose or (np.nan,) * 3 for pose in poses], float).reshape(-1, 3)
    known = ~np.isnan(array[:, 2])
    array[known, 2] = np.unwrap(array[known, 2])
    return array


def list_ray_sensors(robot: RobotDescription) -> dict[str, str]:
    """Return the field of the distances in the samples of each sensor with rays, by the sensor's name."""
    kinds = {each.name: load_kind(each.kind) for each in robot.devices}
    return {
        name: value.field
        for name, kind in kinds.items()
        if getattr(kind.device, "has_rays", False)
        for value in list_values(kind.sample)
        if value.unit == "m"
    }


def read_distances(sample: Any, name: str) -> Array:
    """Return the distances of a sample of a sensor with rays, in metres.

    name: the field of the distances.
    """
    return np.atleast_1d(np.asarray(getattr(sample, name), float))
