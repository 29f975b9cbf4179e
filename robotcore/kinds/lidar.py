"""A lidar, which measures the distance to the nearest body in many directions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from robotcore.description import Body, Ideal, Mount, SensorDescription
from robotcore.description.types import SensorRange
from robotcore.errors import Mistake
from robotcore.geometry import wrap_angle
from robotcore.hal.device import Rays, Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.robot import Robot
from robotcore.hal.simulation_state import SimulationState

__all__ = ["KIND", "Lidar", "LidarDescription", "Scan"]

Array = NDArray[np.float64]

DISTANCE_DECIMALS = 3
"""A simulated distance in metres is rounded to this number of decimals, because lidars send whole millimetres."""

FULL_TURN_RAD = math.tau - 1e-6
"""A field of view of at least this angle is the full circle, in radians."""

MARGIN_M = 0.02
"""A body that is passed at less than this distance is in the robot's way, in metres."""

FRONT_DEPTH_M = 0.05
"""An echo that is less than this distance behind the robot's front is that of a body in front of it, in metres."""

MAX_NOISE = 6
"""The largest noise of a distance, as a multiple of its standard deviation."""

CHART_PX = 480
"""The width of a scan's chart in a notebook, in pixels. Its height is a third of it."""

CHART_TEXT_PX = 12
"""The height of the text line in the chart, in pixels."""

Bearing = Annotated[float, Field(ge=-math.tau, le=math.tau)]
"""An angle from the lidar's direction, in radians, positive to the left."""


class LidarDescription(SensorDescription):
    """A lidar with horizontal rays. The direction of the mount is that of the bearing 0.

    >>> import math
    >>> from robotcore.description import Mount
    >>> lidar = LidarDescription(
    ...     kind="lidar", name="scanner", mount=Mount(z_m=0.12), min_range_m=0.1, max_range_m=8.0, count=4
    ... )
    >>> [round(math.degrees(bearing)) for bearing in lidar.bearings]
    [-180, -90, 0, 90]
    """

    kind: Literal["lidar"]
    mount: Mount
    min_range_m: SensorRange
    """The shortest distance that the lidar measures, in metres. A nearer body gives no echo."""
    max_range_m: SensorRange
    """The longest distance that the lidar measures, in metres."""
    start_rad: Bearing = -math.pi
    """The bearing of the first ray, in radians, positive to the left."""
    end_rad: Bearing = math.pi
    """The end of the field of view, in radians. It is the bearing of the last ray, except with a full circle.

    The last ray of a full circle is one step before it, because the first ray has the same direction as the end.
    """
    count: Annotated[int, Field(ge=2, le=4000)] = 360
    """The number of rays in a scan, from right to left at equal angles."""
    rate_hz: Annotated[float, Field(ge=0.5, le=100)] = 10.0
    """The number of scans in a second."""
    noise_m: Annotated[float, Field(ge=0, le=1), Ideal(0.0)] = 0.0
    """The standard deviation of the distances of a simulated lidar, in metres."""

    @model_validator(mode="after")
    def _require_order(self) -> LidarDescription:
        if self.min_range_m >= self.max_range_m:
            problem = f"min_range_m, {self.min_range_m:g} m, is not below max_range_m, {self.max_range_m:g} m"
            raise Mistake(problem, "Correct one of them", kind="ranges-in-wrong-order")
        if not 0 < self.end_rad - self.start_rad <= math.tau + 1e-6:
            problem = f"start_rad is {self.start_rad:g}, and end_rad is {self.end_rad:g}"
            remedy = "Give an end_rad that is greater by 2π at most"
            raise Mistake(problem, remedy, kind="field-of-view")
        if self.mount.pitch_rad:
            problem = f"mount.pitch_rad is {self.mount.pitch_rad:g}, but the rays of a lidar are horizontal"
            raise Mistake(problem, "Remove pitch_rad", kind="lidar-not-level")
        return self

    @property
    def is_full_circle(self) -> bool:
        """Whether the field of view is the full circle."""
        return self.end_rad - self.start_rad >= FULL_TURN_RAD

    @property
    def bearings(self) -> tuple[float, ...]:
        """The angle of each ray from the lidar's direction, in radians, in ascending order: from right to left."""
        steps = self.count - (not self.is_full_circle)
        step = (self.end_rad - self.start_rad) / steps
        return tuple(self.start_rad + index * step for index in range(self.count))

    def looks_ahead(self, mount: Mount) -> bool:
        middle = (self.start_rad + self.end_rad) / 2
        return abs(wrap_angle(mount.yaw_rad + middle)) <= (self.end_rad - self.start_rad) / 2

    def find_nearest_ahead(self, mount: Mount, front_x_m: float) -> float:
        return max(0.0, self.min_range_m + mount.x_m - front_x_m)

    def arguments(self) -> dict[str, Any]:
        return {"min_range": self.min_range_m, "max_range": self.max_range_m, "bearings": self.bearings}


@dataclass(frozen=True, slots=True)
class Scan:
    """A sample of a lidar: one distance for each ray.

    >>> import math
    >>> scan = Scan(distances=(0.8, math.inf, 1.2), time=1.25, sequence=12)
    >>> scan
    Scan nearest 0.80 m, 2 of 3 rays with an echo at 1.25 s
    >>> min(scan.distances)
    0.8
    """

    distances: Annotated[tuple[float, ...], Unit("m")]
    """The distance along each ray, in metres, in the order of the lidar's ``bearings``.

    It is ``inf`` for a ray without an echo within the lidar's range. A real lidar also gets no echo from a body that is
    too near, too dark, or too shiny.
    """
    time: float
    """The time of the oldest measurement in the scan on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""

    def format_values(self) -> str:
        return self.format_echoes()

    def _repr_png_(self) -> bytes:
        """Return a chart: a column for each ray, from left to right, as high as the ray's distance."""
        from robotcore.canvas import INK, PAPER, SERIES, Canvas, encode_png

        farthest = max(filter(math.isfinite, self.distances), default=0.0)
        canvas = Canvas(CHART_PX, CHART_PX // 3, PAPER)
        width, height = canvas.width / max(1, len(self.distances)), canvas.height - 2 * CHART_TEXT_PX
        for column, distance in enumerate(reversed(self.distances)):
            if math.isfinite(distance) and farthest > 0:
                x, y = column * width, canvas.height - height * distance / farthest
                corners = [(x, y), (x + width, y), (x + width, canvas.height), (x, canvas.height)]
                canvas.fill_polygon(corners, SERIES[3])
        words = f"from left to right, up to {farthest:.2f} m; {self.format_values()}"
        canvas.write_text((CHART_TEXT_PX / 2, CHART_TEXT_PX * 1.5), words, INK, CHART_TEXT_PX * 0.8)
        return encode_png(canvas.render())

    def format_echoes(self, bearings: tuple[float, ...] = ()) -> str:
        """Return the distance of the nearest echo, its bearing, and the number of echoes as text.

        bearings: the bearings of the rays, in radians; empty for a text without the bearing.
        """
        echoes = list(filter(math.isfinite, self.distances))
        counted = f"{len(echoes)} of {len(self.distances)} rays with an echo"
        if not echoes:
            return counted
        nearest = min(echoes)
        where = f" at {math.degrees(bearings[self.distances.index(nearest)]):.0f}°" if bearings else ""
        return f"nearest {nearest:.2f} m{where}, {counted}"


class Lidar(Sensor[Scan]):
    """A sensor that measures the distance to the nearest body in many directions.

    min_range, max_range: the shortest and the longest distance that the lidar measures, in metres.
    bearings: the angle of each ray from the lidar's direction, in radians, in ascending order. A positive bearing is on
        the left.

    ``mount`` is the lidar's pose on the robot in the plane. A run sets it from the robot's description.

    >>> import math
    >>> from robotcore.description import Mount
    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.kinds.lidar import LidarDescription, Scan
    >>> lidar = LidarDescription(
    ...     kind="lidar", name="scanner", mount=Mount(z_m=0.1), min_range_m=0.1, max_range_m=8.0, count=4
    ... )
    >>> scanner = build_sensor(lidar, lambda: Scan((math.inf, 2.0, 0.5, 1.0), 0.0, 0))
    >>> [round(math.degrees(bearing)) for bearing in scanner.bearings]
    [-180, -90, 0, 90]
    >>> scanner.format_sample(scanner.read())
    'nearest 0.50 m at 0°, 3 of 4 rays with an echo'
    """

    kind = "lidar"
    has_rays = True

    def __init__(self, name: str, *, min_range: float, max_range: float, bearings: tuple[float, ...]) -> None:
        super().__init__(name)
        self.min_range, self.max_range, self.bearings = min_range, max_range, bearings

    def list_rays(self, sample: Scan) -> Rays:
        return Rays(self.bearings[0], self.bearings[-1], sample.distances)

    def change_distances(self, sample: Scan, change: Callable[[float, int], float]) -> Scan:
        changed = tuple(change(distance, ray) for ray, distance in enumerate(sample.distances))
        return self.limit_sample(replace(sample, distances=changed))

    def limit_sample(self, sample: Scan) -> Scan:
        """Return a scan that has ``inf`` in place of each distance that is out of the lidar's range."""
        distances = limit_distances(np.array(sample.distances), self.min_range, self.max_range)
        return replace(sample, distances=distances)

    def measure_ahead(self, sample: Scan, mount: Mount, body: Body) -> float:
        """Return the distance from the front of the robot to the nearest echo on its way straight ahead.

        Echoes inside the body's outline are those of parts of the robot, except near its front. The distance is NaN if
        one in the scan is.
        """
        angles = mount.yaw_rad + np.array(self.bearings)
        distances = np.minimum(sample.distances, self.max_range)
        ahead = mount.x_m + distances * np.cos(angles) - body.front_x_m
        aside = np.abs(mount.y_m + distances * np.sin(angles)) - body.width_m / 2
        is_in_the_way = ((ahead >= 0) & (aside <= MARGIN_M)) | ((ahead >= -FRONT_DEPTH_M) & (aside <= 0))
        is_in_the_way &= np.isfinite(sample.distances)
        if np.isnan(ahead).any():
            return math.nan
        return max(0.0, float(ahead[is_in_the_way].min(initial=math.inf)))

    def format_sample(self, sample: Scan) -> str:
        return sample.format_echoes(self.bearings)


def limit_distances(distances: Array, min_range: float, max_range: float) -> tuple[float, ...]:
    """Return distances in metres, with ``inf`` in place of each one that is out of a range."""
    return tuple(np.where((distances >= min_range) & (distances <= max_range), distances, math.inf).tolist())


def simulate(lidar: LidarDescription, state: SimulationState) -> Callable[[float, int], Scan]:
    """Return a function that takes a scan of the bodies around the lidar, at its height.

    All rays of a scan are measured at the same time.
    """
    bearings, reach_m = np.array(lidar.bearings), lidar.max_range_m + MAX_NOISE * lidar.noise_m

    def take(time: float, sequence: int) -> Scan:
        mount = state.joints.locate(lidar.mount)
        angles = mount.yaw_rad + bearings
        rays = np.stack((np.cos(angles), np.sin(angles), np.zeros_like(angles)), axis=1)
        distances = state.cast(np.array((mount.x_m, mount.y_m, mount.z_m)), rays, reach_m)
        distances += state.draw_noises(lidar.name, lidar.noise_m, time, len(distances))
        limited = limit_distances(distances.round(DISTANCE_DECIMALS), lidar.min_range_m, lidar.max_range_m)
        return Scan(limited, time, sequence)

    return take


def validate_sample(lidar: LidarDescription, sample: Scan) -> Scan:
    """Return a scripted scan. Raises ValueError unless it has a distance for each ray."""
    values: Any = sample.distances
    form = f"a list of tuples of {lidar.count} distances in metres, inf without an echo"
    if not isinstance(values, (tuple, list)) or len(values) != lidar.count:
        raise ValueError(form)
    if not all(isinstance(value, (int, float)) and value >= 0 for value in values):
        raise ValueError(form)
    return replace(sample, distances=tuple(map(float, values)))


def check_distances(_robot: Robot, lidar: Lidar) -> None:
    """Check that a scan has one distance for each ray, within the range or ``inf``."""
    distances = lidar.read().distances
    assert len(distances) == len(lidar.bearings), (
        f"{lidar.name} returned {len(distances)} distances for {len(lidar.bearings)} rays. Return one for each ray"
    )
    wrong = [each for each in distances if not (lidar.min_range <= each <= lidar.max_range or each == math.inf)]
    assert not wrong, (
        f"{lidar.name} returned {wrong[0]} m. Return a distance from {lidar.min_range} to {lidar.max_range} m, or inf "
        "for a ray without an echo"
    )


KIND = Kind(
    "a scanner of the distances in many directions",
    LidarDescription,
    Lidar,
    Scan,
    simulate,
    rules=(check_distances,),
    default_reading=lambda lidar: {"distances": (math.inf,) * lidar.count},
    validate_sample=validate_sample,
)
"""The kind `lidar`, which the entry point of this name refers to."""
