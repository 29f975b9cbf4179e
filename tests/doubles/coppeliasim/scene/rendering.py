"""The rendering of a scene: its static shapes, and pictures of vision sensors."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Ball, Floor, Light, WorldDescription
from robotcore.optics import CameraView, Intrinsics
from robotcore.simulation.painter import Painter
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Depths, Node, Pixels, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.outlines import UprightShape, find_upright_shape
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scene.rays import Hits, Solids

ALL_THERE_IS = -1
Rgb = tuple[int, int, int]

FLOOR_M = 0.01
"""A shape whose upper end is below this height, in metres, is floor.

A shape whose lower end is below it stands on the floor.
"""


class Scenery:
    """The present shapes of a scene without its robots. After a change of the scene, a new Scenery must be created.

    Tilted shapes are visible and detectable, but they do not block robots.
    """

    def __init__(self, graph: Graph, hidden: Collection[Node], light: Light, entity: int = ALL_THERE_IS) -> None:
        shown = _shown(graph, entity)
        placed = [(shape, graph.pose(shape)) for shape in shown if shape not in hidden]
        stands = {shape: find_upright_shape(shape, pose) for shape, pose in placed}
        upright = [each for each in stands.values() if each]
        self._light = light
        self._painters: dict[Rgb, Painter] = {}
        self.floors = sorted((each for each in upright if each.high <= FLOOR_M), key=lambda each: -each.high)
        self.obstacles = [each for each in upright if each.high > FLOOR_M]
        self.solids = Solids(placed)
        self._is_paintable = all(each and (each in self.floors or _is_on_floor(each)) for each in stands.values())

    def painter(self, sky: Rgb) -> Painter | None:
        """Return a painter of the scenery; None if a shape does not stand on the floor, which requires ray casting."""
        if not self._is_paintable:
            return None
        if sky not in self._painters:
            self._painters[sky] = Painter(self.describe(self.obstacles, sky))
        return self._painters[sky]

    def find_obstacles(self, low: float, high: float) -> list[UprightShape]:
        """Return the obstacles between two heights: boxes and cylinders, then balls."""
        reached = [each for each in self.obstacles if each.low < high and each.high > low]
        return sorted(reached, key=lambda each: isinstance(each.description, Ball))

    def describe(self, obstacles: Iterable[UprightShape], sky: Rgb = (0, 0, 0)) -> WorldDescription:
        """Return the description of a world with these obstacles.

        Without a floor, the ground has the colour of the sky.
        """
        descriptions = [each.description for each in obstacles]
        return WorldDescription.model_construct(
            name="scene",
            floor=Floor.model_construct(length_m=100.0, width_m=100.0, colour=self._ground or sky),
            light=self._light.model_copy(update={"sky_colour": sky}),
            obstacles=tuple(description for description in descriptions if not isinstance(description, Ball)),
            targets=tuple(description for description in descriptions if isinstance(description, Ball)),
        )

    @property
    def _ground(self) -> Rgb | None:
        return self.floors[0].description.colour if self.floors else None


def _shown(graph: Graph, entity: int) -> list[Shape]:
    if entity == ALL_THERE_IS:
        return graph.all_of(Shape)
    members = graph.collections[entity].members(graph)
    return [shape for shape in graph.all_of(Shape) if shape in members]


def _is_on_floor(each: UprightShape) -> bool:
    return each.low <= FLOOR_M and (not isinstance(each.description, Ball) or each.low >= -FLOOR_M)


Array = NDArray[np.float64]

LEVEL = 1e-6
"""The tolerance for the roll of a camera. The painter supports cameras without roll only."""

EMPTY = 1.63e-5
"""In the recordings, the depth of a pixel without an object is below ``far`` by this fraction of the range."""


def view_of(sensor: VisionSensor, pose: Transform) -> CameraView:
    """Return the camera view of a sensor, whose z axis points forward, y up and x to the left."""
    left, up, ahead = (np.array(axis) for axis in pose.axes)
    return CameraView(intrinsics_of(sensor), np.array(pose.position), np.array((-left, -up, ahead)))


def intrinsics_of(sensor: VisionSensor) -> Intrinsics:
    """Return the intrinsics of a sensor, whose angle is across the longer side of its picture."""
    wide = math.tan(sensor.angle / 2) * min(1.0, sensor.width / sensor.height)
    return Intrinsics(sensor.width, sensor.height, 2 * math.atan(wide))


class RenderedPicture:
    """A picture of a sensor. It is rendered when it is read first. Row 0 is the lowest."""

    def __init__(self, sensor: VisionSensor, pose: Transform, scenery: Scenery, light: Light) -> None:
        self._sensor, self._pose, self._scenery = sensor, pose, scenery
        self._light = light.model_copy(update={"sky_colour": _sky(sensor, light)})

    @cached_property
    def picture(self) -> Pixels:
        """The picture: red, green and blue, (height, width, 3)."""
        view = view_of(self._sensor, self._pose)
        painter = self._scenery.painter(self._light.sky_colour) if abs(view.rotation[0, 2]) < LEVEL else None
        if painter:
            return painter.picture(view)[::-1, :, ::-1]
        return _cast_rays(view, self._sensor, self._scenery, self._light)

    @cached_property
    def depths(self) -> Depths:
        """The depths along the optical axis, (height, width), in metres."""
        return self.depths_of_every(1)

    def depths_of_every(self, nth: int) -> Depths:
        """Return the depths of each ``nth`` pixel of each ``nth`` row."""
        sensor, view = self._sensor, view_of(self._sensor, self._pose)
        rays = _compute_ray_directions(view, nth)
        lengths = self._scenery.solids.cast(view.eye, rays.reshape(-1, 3))
        empty = sensor.far - EMPTY * (sensor.far - sensor.near)
        lengths = np.where((lengths >= sensor.near) & (lengths <= sensor.far), lengths, empty)
        return lengths.reshape(rays.shape[:2]).astype(np.float32)


@dataclass(frozen=True)
class BlankPicture:
    """The picture of a sensor that was never rendered, or that shows a received picture."""

    picture: Pixels
    depths: Depths

    @classmethod
    def of(cls, sensor: VisionSensor, picture: Pixels | None = None) -> BlankPicture:
        """Return a picture, by default black, with depths of exactly ``far``."""
        size = sensor.height, sensor.width
        black = np.zeros((*size, 3), np.uint8)
        return cls(black if picture is None else picture, np.full(size, sensor.far, np.float32))

    def depths_of_every(self, nth: int) -> Depths:
        return self.depths[::nth, ::nth]


def _sky(sensor: VisionSensor, light: Light) -> tuple[int, int, int]:
    if sensor.background is None:
        return light.sky_colour
    red, green, blue = (round(255 * part) for part in sensor.background)
    return red, green, blue


def _cast_rays(view: CameraView, sensor: VisionSensor, scenery: Scenery, light: Light) -> Pixels:
    hits = scenery.solids.hits(view.eye, _compute_ray_directions(view).reshape(-1, 3))
    is_seen = (hits.lengths >= sensor.near) & (hits.lengths <= sensor.far)
    colours = np.where(is_seen[:, None], _shade_hits(hits, scenery, light), light.sky_colour)
    return np.rint(colours).astype(np.uint8).reshape(sensor.height, sensor.width, 3)


def _shade_hits(hits: Hits, scenery: Scenery, light: Light) -> Array:
    palette = 255 * np.array([shape.colour for shape in scenery.solids.shapes] or [(0.0, 0.0, 0.0)])
    cosines = np.maximum(hits.normals @ np.array(light.direction), 0.0)
    shade = np.minimum(light.ambient + light.diffuse * cosines, 1.0) * light.brightness
    return np.asarray(np.minimum(palette[hits.solids] * shade[:, None], 255.0))


def _compute_ray_directions(view: CameraView, nth: int = 1) -> Array:
    """Return the rays through the centres of each ``nth`` pixel, (rows, columns, 3), up to depth 1 m.

    Row 0 is the lowest.
    """
    i = view.intrinsics
    right = (np.arange(0, i.width, nth) - i.cx) / i.focal_length
    down = (np.arange(i.height - 1, -1, -nth) - i.cy) / i.focal_length
    across, along = view.rotation[0] * right[:, None], view.rotation[1] * down[:, None]
    return np.asarray(across[None] + along[:, None] + view.rotation[2])
