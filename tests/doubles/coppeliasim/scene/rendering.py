"""The scenery that sensors see: shapes as prisms and balls of a world, pictures, depths and detections."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from drivers.kinematic.devices import cast_at_circles
from robotcore.description import Ball, Box, Cylinder, Floor, Light, WorldDescription
from robotcore.optics import CameraView, Intrinsics
from robotcore.raycast import Array, Fan, cast, edges_of
from robotcore.simulation.painter import Painter
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import (
    Depths,
    Node,
    Pixels,
    Primitive,
    ProximitySensor,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import ORIGIN, Transform, Vector

DEFAULT_LIGHT = Light(elevation_rad=math.pi / 2, ambient=0.57, diffuse=0.38, sky_colour=(0, 0, 0))
"""The light of the recorded pictures: from above, with a black background."""

EVERYTHING = -1
FLOOR_M = 0.01
"""A shape whose upper end is below this height, in metres, is floor."""
NEAREST_M = 0.001

Rgb = tuple[int, int, int]


class Detection(NamedTuple):
    """A detection of a proximity sensor: the distance in metres, the point in the sensor's frame, and the handle."""

    distance: float
    point: Vector
    handle: int


class PlacedShape(NamedTuple):
    """An upright shape: its description in a world, and the heights of its lower and upper end."""

    shape: Shape
    description: Box | Cylinder | Ball
    low: float
    high: float

    @classmethod
    def of(cls, shape: Shape, pose: Transform) -> PlacedShape:
        """Return the upright shape at ``pose``. The z axis of a box or cylinder must be vertical."""
        (x, y, z), (length, width, height) = pose.position, shape.size
        common: dict[str, Any] = {"name": shape.alias, "x_m": x, "y_m": y, "colour": _to_rgb(shape.colour)}
        upright = {**common, "yaw_rad": pose.yaw, "height_m": z + height / 2, "texture": None}
        description: Box | Cylinder | Ball
        if shape.primitive is Primitive.CUBOID:
            description = Box.model_construct(shape="box", length_m=length, width_m=width, **upright)
        elif shape.primitive is Primitive.CYLINDER:
            description = Cylinder.model_construct(shape="cylinder", radius_m=length / 2, **upright)
        else:
            description = Ball.model_construct(radius_m=length / 2, **common)
        return cls(shape, description, z - height / 2, z + height / 2)

    def cast(self, origin: Vector, dx: Array, dy: Array) -> Array:
        """Return the distance of horizontal rays to the shape, as multiples of the length of their vectors, (n,)."""
        x, y, z = origin
        if not self.low < z < self.high:
            return np.full(dx.shape, math.inf)
        if not isinstance(self.description, Ball):
            return cast(x, y, dx, dy, edges_of([self.description.outline]))
        lengths = np.maximum(np.hypot(dx, dy), NEAREST_M)
        squared_radius = (z - self.low) * (self.high - z)
        circle = np.array([(self.description.x_m, self.description.y_m, squared_radius)])
        return cast_at_circles(x, y, dx / lengths, dy / lengths, circle) / lengths


class Scenery:
    """The upright shapes of a scene without its robots. After a change of the scene, a new Scenery must be created."""

    def __init__(self, shapes: Sequence[PlacedShape], light: Light) -> None:
        self._light = light
        floors = sorted((each for each in shapes if each.high <= FLOOR_M), key=lambda each: each.high)
        self._ground = floors[-1].description.colour if floors else None
        obstacles = [each for each in shapes if each.high > FLOOR_M]
        self.obstacles = sorted(obstacles, key=lambda each: isinstance(each.description, Ball))
        self.painter = cache(self._create_painter)

    @classmethod
    def of(cls, graph: Graph, light: Light, robots: Collection[Node], entity: int) -> Scenery:
        """Return the scenery of a collection's members, or of all objects."""
        shown = set(graph) if entity == EVERYTHING else graph.collections[entity]
        shapes = [shape for shape in graph.all_of(Shape) if shape in shown and shape not in robots]
        return cls([PlacedShape.of(shape, graph.pose(shape)) for shape in shapes], light)

    def describe(self, obstacles: Sequence[PlacedShape], sky: Rgb | None = None) -> WorldDescription:
        """Return the description of a world with these obstacles.

        Without a floor, the ground has the colour of the sky.
        """
        descriptions = [each.description for each in obstacles]
        sky = sky or self._light.sky_colour
        return WorldDescription.model_construct(
            name="scene",
            floor=Floor.model_construct(length_m=100.0, width_m=100.0, colour=self._ground or sky),
            light=self._light.model_copy(update={"sky_colour": sky}),
            obstacles=tuple(description for description in descriptions if not isinstance(description, Ball)),
            targets=tuple(description for description in descriptions if isinstance(description, Ball)),
        )

    def cast(self, origin: Vector, dx: Array, dy: Array) -> tuple[Array, Array]:
        """Return the distance of each horizontal ray to the first obstacle, and the obstacle's handle, both (n,).

        The unit of a distance is the length of the ray's direction vector. Without a hit it is ``inf``.
        """
        if not self.obstacles:
            return np.full(dx.shape, math.inf), np.full(dx.shape, -1)
        lengths = np.array([each.cast(origin, dx, dy) for each in self.obstacles])
        handles = np.array([each.shape.handle for each in self.obstacles])
        return lengths.min(axis=0), handles[lengths.argmin(axis=0)]

    def detect(self, sensor: ProximitySensor, pose: Transform) -> Detection | None:
        """Return the detection of a level sensor at ``pose``; None if it detects nothing."""
        left, _, ahead = (np.array(axis) for axis in pose.axes)
        angles = Fan(sensor.cone, 0.0, sensor.reach).angles
        rays = np.outer(np.sin(angles), left) + np.outer(np.cos(angles), ahead)
        x, y, z = np.array(pose.position) - sensor.setback * ahead
        lengths, handles = self.cast((x, y, z), rays[:, 0], rays[:, 1])
        ray = int(lengths.argmin())
        if (distance := float(lengths[ray]) - sensor.setback) > sensor.reach:
            return None
        distance, angle = max(distance, NEAREST_M), float(angles[ray])
        return Detection(distance, (distance * math.sin(angle), 0.0, distance * math.cos(angle)), int(handles[ray]))

    def _create_painter(self, sky: Rgb | None) -> Painter:
        return Painter(self.describe(self.obstacles, sky))


class View:
    """A picture of a sensor, and its depths. They are computed when they are read first.

    Without a scenery, the picture is black, and all depths are ``far``.
    """

    def __init__(self, sensor: VisionSensor, pose: Transform = ORIGIN, scenery: Scenery | None = None) -> None:
        self._sensor, self._pose, self._scenery = sensor, pose, scenery
        wide = math.tan(sensor.angle / 2) * min(1.0, sensor.width / sensor.height)
        self._intrinsics = Intrinsics(sensor.width, sensor.height, 2 * math.atan(wide))

    @cached_property
    def picture(self) -> Pixels:
        """The picture: red, green and blue, (height, width, 3). Row 0 is the lowest."""
        if self._scenery is None:
            return np.zeros((self._sensor.height, self._sensor.width, 3), np.uint8)
        left, up, ahead = (np.array(axis) for axis in self._pose.axes)
        view = CameraView(self._intrinsics, np.array(self._pose.position), np.array((-left, -up, ahead)))
        sky = None if self._sensor.background is None else _to_rgb(self._sensor.background)
        return self._scenery.painter(sky).picture(view)[::-1, :, ::-1]

    @cached_property
    def depths(self) -> Depths:
        """The depths of a level sensor along its optical axis, in metres. All rows have the depths at its height."""
        sensor, i = self._sensor, self._intrinsics
        depths = np.full(sensor.width, sensor.far)
        if self._scenery is not None:
            left, _, ahead = (np.array(axis) for axis in self._pose.axes)
            rays = ahead + np.outer((i.cx - np.arange(i.width)) / i.focal_length, left)
            lengths, _ = self._scenery.cast(self._pose.position, rays[:, 0], rays[:, 1])
            depths = np.where((lengths >= sensor.near) & (lengths <= sensor.far), lengths, sensor.far)
        return np.tile(depths.astype(np.float32), (sensor.height, 1))


def _to_rgb(colour: Vector) -> Rgb:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
