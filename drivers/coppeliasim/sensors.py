"""Vision sensors, proximity sensors, and the range sensors that use them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers.coppeliasim.builder import FORWARD, NO_UNDO, Placement, SceneBuilder, place_mount
from drivers.coppeliasim.connection import Connection
from robotcore.description import RangeSensorDescription
from robotcore.errors import BackendError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Range, RangeSensor
from robotcore.raycast import FAN_RAYS, FAN_SETBACK_M, Fan
from robotcore.simulation.remote_scene import Point, Scene
from robotcore.simulation.sampling import SampleCache

NEAR_M, FAR_M = 0.01, 40.0
_EXPLICIT_VISION, _PERSPECTIVE, _OWN_BACKGROUND = 1, 2, 128


@dataclass(frozen=True)
class VisionSensorSpec:
    """A vision sensor that is to be: ``size`` in pixels, a horizontal field of view, what is near and far in metres.

    ``empty`` is the grey, from 0 to 1, where nothing is, and ``seen`` the collection that it sees; -1 is all there is.
    What is ``ignored``, ``"depth"`` or ``"rgb"``, is not rendered.
    """

    size: tuple[int, int]
    fov: float
    near_m: float = NEAR_M
    far_m: float = FAR_M
    empty: float = 0.0
    seen: int = -1
    ignored: str = ""


def add_vision_sensor(builder: SceneBuilder, eye: VisionSensorSpec, alias: str, place: Placement, parent: int) -> int:
    """Make a vision sensor that renders when it is told to."""
    floats = [eye.near_m, eye.far_m, perspective_angle(eye.fov, *eye.size), 0.02, 0, 0, *[eye.empty] * 3, 0, 0]
    options = _EXPLICIT_VISION | _PERSPECTIVE | _OWN_BACKGROUND
    sensor = builder.make("createVisionSensor", options, [*eye.size, 0, 0], floats)
    builder.set_int(sensor, "visionintparam_entity_to_render", eye.seen)
    if eye.ignored:
        builder.set_int(sensor, f"visionintparam_{eye.ignored}ignored", 1)
    builder.put(sensor, place, alias, parent)
    return sensor


def perspective_angle(fov: float, width: int, height: int) -> float:
    """Return the perspective angle, which is that of a picture's longer side, for a horizontal field of view."""
    return fov if width >= height else 2 * math.atan(math.tan(fov / 2) * height / width)


BOX_M = 0.45
"""How far the box's near side is from the sensor."""

_SIDE_M = 0.1
_AWAY = Placement(0.0, 0.0, 900.0)
"""Where nothing else is."""


@contextmanager
def probe_with_box(builder: SceneBuilder, make: Callable[[], int]) -> Iterator[int]:
    """Make a sensor with a box right in front of it, far from all else, and remove both; yields the sensor."""
    made: list[int] = []
    try:
        cuboid = builder.constant("primitiveshape_cuboid")
        made.append(box := builder.make("createPrimitiveShape", cuboid, [_SIDE_M] * 3, 0))
        builder.mark(box, NO_UNDO)
        made.append(sensor := make())
        builder.mark(sensor, NO_UNDO)
        builder.put(box, _AWAY._replace(x=BOX_M + _SIDE_M / 2), "robotcore_probe", -1)
        builder.put(sensor, _AWAY.at(FORWARD), "robotcore_probe_sensor", -1)
        yield sensor
    finally:
        builder.call("removeObjects", made)


_PYRAMID, _EXPLICIT_PROXIMITY = 30, 1
_ULTRASONIC = 16
_THIN_M = 1e-3
"""How high the volume is that is looked into: it is a fan, and does not see the floor."""


def proximity_works(builder: SceneBuilder, detect: Callable[[int], Point | None]) -> bool:
    """Return whether ``detect`` returns a point for a proximity sensor with a box right in front of it.

    Without its plug-in a CoppeliaSim answers "nothing", and the way would seem free.
    """
    with probe_with_box(builder, partial(_make_pyramid, builder, reach=1.0, cone=0.5)) as sensor:
        return detect(sensor) is not None


def add_proximity_sensor(
    builder: SceneBuilder, description: RangeSensorDescription, body: int, frame: Placement, met: int
) -> int:
    """Make a flat fan that begins inside the body, and detects what is in a collection."""
    sensor = _make_pyramid(builder, description.max_range_m + FAN_SETBACK_M, description.cone_rad)
    builder.set_int(sensor, "proxintparam_entity_to_detect", met)
    builder.put(sensor, frame.at(place_mount(description.mount, behind_m=FAN_SETBACK_M)), description.name, body)
    return sensor


class ProximityRangeSensor(RangeSensor):
    """The way to the nearest point that a proximity sensor detects."""

    def __init__(self, scene: Scene, description: RangeSensorDescription, sensor: int, clock: Clock) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._scene, self._sensor, self._fan = scene, sensor, Fan(cone=description.cone_rad, **limits)
        self._newest_at = SampleCache(clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        if (point := self._scene.detect(self._sensor)) is None:
            return Range(math.inf, time, sequence)
        left, up, ahead = point
        distance = self._fan.reading(np.array([math.hypot(*point)]))
        return Range(distance, time, sequence, None if math.isinf(distance) else (ahead - FAN_SETBACK_M, left, up))


def _make_pyramid(builder: SceneBuilder, reach: float, cone: float) -> int:
    """Make a pyramid that opens sideways by ``cone``, and hardly upwards."""
    side = 2 * reach * math.tan(cone / 2)
    return builder.make(
        "createProximitySensor",
        _PYRAMID,
        _ULTRASONIC,
        _EXPLICIT_PROXIMITY,
        [32, 0, 4, 1, 1, 1, 0, 0],
        [0.0, reach, _THIN_M, _THIN_M, side, _THIN_M, 0, 0, 0, 0, 0, 0, 0.01, 0, 0],
    )


_PROBED_M = 0.01

Array = NDArray[np.float64]

BEAM_RAD = 0.01
_JUST_UNDER = 1e-3
"""Where nothing is in view, depth reads a little less than the farthest."""


def add_fan(builder: SceneBuilder, description: RangeSensorDescription, body: int, frame: Placement, met: int) -> int:
    """Make the vision sensor of a fan; its outermost pixels look along the edges of the cone, at a collection."""
    cone = max(description.cone_rad, BEAM_RAD)
    fov = 2 * math.atan(math.tan(cone / 2) * FAN_RAYS / (FAN_RAYS - 1))
    eye = VisionSensorSpec((FAN_RAYS, 1), fov, far_m=fan_reach(description), seen=met, ignored="rgb")
    return add_vision_sensor(
        builder, eye, description.name, frame.at(place_mount(description.mount, behind_m=FAN_SETBACK_M)), body
    )


def fan_reach(description: RangeSensorDescription) -> float:
    """Return how far the fan looks, from where its rays begin, in metres."""
    return description.max_range_m + 2 * FAN_SETBACK_M


def require_depth(builder: SceneBuilder, connection: Connection) -> None:
    """Raise BackendError where a box right in front of a vision sensor is not seen.

    One that is not rendered, for want of graphics, tells the farthest depth: the way would seem free.
    """
    eye = VisionSensorSpec((FAN_RAYS, 1), BEAM_RAD, far_m=2 * BOX_M, ignored="rgb")
    with probe_with_box(builder, partial(add_vision_sensor, builder, eye, "", Placement(0.0, 0.0, 0.0), -1)) as sensor:
        seen = _read_depths(connection, sensor).min()
    if abs(seen - BOX_M) > _PROBED_M:
        raise BackendError(
            f"coppeliasim: the CoppeliaSim at {connection.address} measures no distances: it does not detect a box in "
            f"front of a proximity sensor, and a vision sensor sees it {seen:.2f} m away, which is {BOX_M} m. Start it "
            "where it can draw (OpenGL), or take one with the plug-in for proximity sensors"
        )


class FanRangeSensor(RangeSensor):
    """Reads depth along the optical axis, and divides it by each ray's cosine."""

    def __init__(self, connection: Connection, description: RangeSensorDescription, sensor: int, clock: Clock) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._connection, self._sensor = connection, sensor
        self._fan = Fan(cone=description.cone_rad, **limits)
        side = np.tan(max(description.cone_rad, BEAM_RAD) / 2)
        self._slopes = np.linspace(side, -side, FAN_RAYS)  # the first pixel is the leftmost
        self._stretch = np.hypot(1.0, self._slopes)
        self._far = fan_reach(description) * (1 - _JUST_UNDER)
        self._newest_at = SampleCache(clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        depth = _read_depths(self._connection, self._sensor)
        lengths = np.where(depth < self._far, depth * self._stretch, math.inf)
        distance = self._fan.reading(lengths)
        return Range(distance, time, sequence, None if math.isinf(distance) else self._point(lengths))

    def _point(self, lengths: Array) -> tuple[float, float, float]:
        """Return the detected point in the sensor's frame."""
        ray = int(lengths.argmin())
        ahead = float(lengths[ray] / self._stretch[ray])
        return ahead - FAN_SETBACK_M, ahead * float(self._slopes[ray]), 0.0


def _read_depths(connection: Connection, sensor: int) -> Array:
    """Return how far a vision sensor sees now, in metres."""
    connection.sim("handleVisionSensor", sensor)  # unasked, it tells the depth of before
    return connection.call_as(_to_depths, "getVisionSensorDepth", sensor, 1)


def _to_depths(answer: object) -> Array:
    """Return a row of depths in metres; raises ValueError where it is none."""
    if not (isinstance(answer, tuple) and isinstance(answer[0], bytes) and len(answer[0]) == 4 * FAN_RAYS):
        raise ValueError("no row of depths")
    return np.frombuffer(answer[0], dtype="<f4").astype(np.float64)
