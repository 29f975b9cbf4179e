"""Vision sensors and proximity sensors of a built robot, and the range sensors that use them."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers.coppeliasim.builder import FORWARD, NO_UNDO, Placement, SceneBuilder, place_mount
from drivers.coppeliasim.connection import SimulatorConnection
from robotcore.errors import BackendError
from robotcore.hal.clock import Clock
from robotcore.kinds.range_sensor import Echo, RangeSensorDescription, SimulatedRangeSensor
from robotcore.raycast import FAN_RAYS, FAN_SETBACK_M, Fan
from robotcore.simulation.remote_scene import Point, Scene

NEAR_M, FAR_M = 0.01, 40.0
_EXPLICIT_VISION, _PERSPECTIVE, _OWN_BACKGROUND = 1, 2, 128


@dataclass(frozen=True)
class VisionSensorSpec:
    """The parameters of a new vision sensor."""

    size: tuple[int, int]
    """Width and height in pixels."""
    fov: float
    """The horizontal field of view in radians."""
    near_m: float = NEAR_M
    """The distance from the sensor to the near clipping plane."""
    far_m: float = FAR_M
    """The distance from the sensor to the far clipping plane."""
    background: float = 0.0
    """The grey level of the background, from 0 for black to 1 for white."""
    visible: int = -1
    """The handle of the collection of visible objects; -1 stands for all objects."""
    ignored: str = ""
    """``"depth"`` if the sensor renders no depths, ``"rgb"`` if it renders no colours, or "" if it renders both."""


def add_vision_sensor(builder: SceneBuilder, spec: VisionSensorSpec, alias: str, frame: Placement, parent: int) -> int:
    """Create a vision sensor, and return its handle. It renders only on request (explicit handling)."""
    floats = [spec.near_m, spec.far_m, compute_perspective_angle(spec.fov, *spec.size), 0.02, 0, 0]
    floats += [*[spec.background] * 3, 0, 0]
    options = _EXPLICIT_VISION | _PERSPECTIVE | _OWN_BACKGROUND
    sensor = builder.make("createVisionSensor", options, [*spec.size, 0, 0], floats)
    builder.set_int(sensor, "visionintparam_entity_to_render", spec.visible)
    if spec.ignored:
        builder.set_int(sensor, f"visionintparam_{spec.ignored}ignored", 1)
    builder.put(sensor, frame, alias, parent)
    return sensor


def compute_perspective_angle(fov: float, width: int, height: int) -> float:
    """Convert a horizontal field of view to the field of view across the longer side of the picture, in radians.

    >>> compute_perspective_angle(1.0, 320, 240)
    1.0
    """
    return fov if width >= height else 2 * math.atan(math.tan(fov / 2) * height / width)


BOX_M = 0.45
"""The distance from the sensor to the near side of the box in `probe_with_box`, in metres."""

_SIDE_M = 0.1
_AWAY = Placement(0.0, 0.0, 900.0)
"""The frame of the sensor in `probe_with_box`, far above the scene."""


@contextmanager
def probe_with_box(builder: SceneBuilder, make: Callable[[], int]) -> Iterator[int]:
    """Return a context manager that creates a sensor with a box in front of it, far from other objects.

    make: creates the sensor, and returns its handle.

    Its value is the handle of the sensor. At the end it removes the sensor and the box.
    """
    created: list[int] = []
    try:
        cuboid = builder.constant("primitiveshape_cuboid")
        created.append(box := builder.make("createPrimitiveShape", cuboid, [_SIDE_M] * 3, 0))
        builder.write_note(box, NO_UNDO)
        created.append(sensor := make())
        builder.write_note(sensor, NO_UNDO)
        builder.put(box, _AWAY._replace(x=BOX_M + _SIDE_M / 2), "robotcore_probe", -1)
        builder.put(sensor, _AWAY.compose(FORWARD), "robotcore_probe_sensor", -1)
        yield sensor
    finally:
        builder.call("removeObjects", created)


_PYRAMID, _EXPLICIT_PROXIMITY = 30, 1
_ULTRASONIC = 16
_THIN_M = 1e-3
"""The height of a proximity sensor's detection volume, in metres. It is so small that the floor is not detected."""


def do_proximity_sensors_work(builder: SceneBuilder, detect: Callable[[int], Point | None]) -> bool:
    """Return whether a new proximity sensor detects a box in front of it.

    detect: returns the point that a sensor detects. Its argument is the handle of the sensor.

    A CoppeliaSim without the plug-in for proximity sensors reports no detection, and a robot would detect no obstacles.
    """
    with probe_with_box(builder, partial(_create_pyramid, builder, reach=1.0, cone=0.5)) as sensor:
        return detect(sensor) is not None


def add_proximity_sensor(
    builder: SceneBuilder, description: RangeSensorDescription, body: int, frame: Placement, detectable: int
) -> int:
    """Create a proximity sensor with a flat detection volume that begins inside the body, and return its handle.

    description: the range sensor of the robot.
    body: the handle of the robot's body.
    frame: the robot's frame in the world.
    detectable: the handle of the collection of objects that the sensor detects.
    """
    sensor = _create_pyramid(builder, description.max_range_m + FAN_SETBACK_M, description.cone_rad)
    builder.set_int(sensor, "proxintparam_entity_to_detect", detectable)
    builder.put(sensor, frame.compose(place_mount(description.mount, behind_m=FAN_SETBACK_M)), description.name, body)
    return sensor


class BuiltRangeSensor(SimulatedRangeSensor):
    """A range sensor of a built robot, which measures from a point behind its mount, inside the body."""

    def __init__(self, description: RangeSensorDescription, clock: Clock, seed: int) -> None:
        self._fan = Fan(description.cone_rad, description.min_range_m, description.max_range_m)
        super().__init__(description, clock, self._measure, seed)

    @abstractmethod
    def _find_nearest(self) -> tuple[float, Point] | None:
        """Return the reading in metres, and the nearest point as lengths ahead, left and up; None without a point."""

    def _measure(self) -> Echo:
        nearest = self._find_nearest()
        if nearest is None or math.isinf(nearest[0]):
            return Echo(math.inf, None)
        distance, (ahead, left, up) = nearest
        return Echo(distance, (ahead - FAN_SETBACK_M, left, up))


class ProximityRangeSensor(BuiltRangeSensor):
    """A range sensor that returns the distance to the nearest point that a proximity sensor detects."""

    def __init__(self, scene: Scene, description: RangeSensorDescription, sensor: int, clock: Clock, seed: int) -> None:
        self._scene, self._sensor = scene, sensor
        super().__init__(description, clock, seed)

    def _find_nearest(self) -> tuple[float, Point] | None:
        if (point := self._scene.detect(self._sensor)) is None:
            return None
        left, up, ahead = point
        return self._fan.reading(np.array([math.hypot(*point)])), (ahead, left, up)


def _create_pyramid(builder: SceneBuilder, reach: float, cone: float) -> int:
    """Create a proximity sensor whose detection volume is a flat pyramid, and return its handle.

    reach: the length of the pyramid, in metres.
    cone: the horizontal opening angle of the pyramid, in radians.
    """
    side = 2 * reach * math.tan(cone / 2)
    return builder.make(
        "createProximitySensor",
        _PYRAMID,
        _ULTRASONIC,
        _EXPLICIT_PROXIMITY,
        [32, 0, 4, 1, 1, 1, 0, 0],
        [0.0, reach, _THIN_M, _THIN_M, side, _THIN_M, 0, 0, 0, 0, 0, 0, 0.01, 0, 0],
    )


_DEPTH_TOLERANCE_M = 0.01

Array = NDArray[np.float64]

BEAM_RAD = 0.01
_FAR_TOLERANCE = 1e-3
"""The relative tolerance of the maximum depth. A pixel without an object has a depth slightly below the maximum."""


def add_fan(
    builder: SceneBuilder, description: RangeSensorDescription, body: int, frame: Placement, detectable: int
) -> int:
    """Create the vision sensor of a `FanRangeSensor`, and return its handle.

    description: the range sensor of the robot. The outermost pixels are at the edges of its cone.
    body: the handle of the robot's body.
    frame: the robot's frame in the world.
    detectable: the handle of the collection of objects that the vision sensor sees.
    """
    cone = max(description.cone_rad, BEAM_RAD)
    fov = 2 * math.atan(math.tan(cone / 2) * FAN_RAYS / (FAN_RAYS - 1))
    spec = VisionSensorSpec((FAN_RAYS, 1), fov, far_m=compute_fan_reach(description), visible=detectable, ignored="rgb")
    return add_vision_sensor(
        builder, spec, description.name, frame.compose(place_mount(description.mount, behind_m=FAN_SETBACK_M)), body
    )


def compute_fan_reach(description: RangeSensorDescription) -> float:
    """Return the distance to the far clipping plane of a `FanRangeSensor`'s vision sensor, in metres."""
    return description.max_range_m + 2 * FAN_SETBACK_M


def require_depth(builder: SceneBuilder, connection: SimulatorConnection) -> None:
    """Raise BackendError if a new vision sensor does not measure the distance to a box in front of it.

    A CoppeliaSim without graphics returns the maximum depth. Then a robot would detect no obstacles.
    """
    spec = VisionSensorSpec((FAN_RAYS, 1), BEAM_RAD, far_m=2 * BOX_M, ignored="rgb")
    with probe_with_box(builder, partial(add_vision_sensor, builder, spec, "", Placement(0.0, 0.0, 0.0), -1)) as sensor:
        distance_m = float(_read_depths(connection, sensor).min())
    if abs(distance_m - BOX_M) > _DEPTH_TOLERANCE_M:
        raise BackendError(
            f"coppeliasim: the CoppeliaSim at {connection.address} measures no distances: a proximity sensor does not "
            f"detect a box in front of it, and a vision sensor measures {distance_m:.2f} m to a box at {BOX_M} m. "
            "Start CoppeliaSim with graphics (OpenGL), or install one with the plug-in for proximity sensors",
            kind="no-distances",
            address=str(connection.address),
            distance_m=distance_m,
        )


class FanRangeSensor(BuiltRangeSensor):
    """A range sensor that measures distances with the depth picture of a vision sensor.

    A depth is a length along the optical axis. So the distance at a pixel is its depth divided by the cosine of the
    angle between the pixel's ray and this axis.
    """

    def __init__(
        self,
        connection: SimulatorConnection,
        description: RangeSensorDescription,
        sensor: int,
        clock: Clock,
        seed: int,
    ) -> None:
        self._connection, self._sensor = connection, sensor
        side = np.tan(max(description.cone_rad, BEAM_RAD) / 2)
        self._slopes = np.linspace(side, -side, FAN_RAYS)  # the first pixel is the leftmost
        self._stretch = np.hypot(1.0, self._slopes)
        self._far = compute_fan_reach(description) * (1 - _FAR_TOLERANCE)
        super().__init__(description, clock, seed)

    def _find_nearest(self) -> tuple[float, Point]:
        depths = _read_depths(self._connection, self._sensor)
        lengths = np.where(depths < self._far, depths * self._stretch, math.inf)
        ray = int(lengths.argmin())
        ahead = float(depths[ray])
        return self._fan.reading(lengths), (ahead, ahead * float(self._slopes[ray]), 0.0)


def _read_depths(connection: SimulatorConnection, sensor: int) -> Array:
    connection.sim("handleVisionSensor", sensor)  # without this, the sensor returns the previous depths
    return connection.call_as(_to_depths, "getVisionSensorDepth", sensor, 1)


def _to_depths(answer: object) -> Array:
    if not (isinstance(answer, tuple) and isinstance(answer[0], bytes) and len(answer[0]) == 4 * FAN_RAYS):
        raise ValueError(f"is not a row of {FAN_RAYS} depths")
    return np.frombuffer(answer[0], dtype="<f4").astype(np.float64)
