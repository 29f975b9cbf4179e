"""What does not move by itself: the floor, and all that a robot may drive against or a sensor see."""

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
from tests.doubles.coppeliasim.scene.objects import Depths, Pixels, Shape, Thing, VisionSensor
from tests.doubles.coppeliasim.scene.outlines import Standing, standing
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scene.rays import Hits, Solids

ALL_THERE_IS = -1
Rgb = tuple[int, int, int]

FLOOR_M = 0.01
"""What ends below this is floor; what begins below it stands on the floor."""


class Scenery:
    """The shapes of a scene without its robots, as they are now. Made anew when somebody changes the scene.

    Tilted shapes are seen and ranged, and nothing is blocked by them.
    """

    def __init__(self, graph: Graph, hidden: Collection[Thing], light: Light, entity: int = ALL_THERE_IS) -> None:
        shown = _shown(graph, entity)
        placed = [(shape, graph.pose(shape)) for shape in shown if shape not in hidden]
        stands = {shape: standing(shape, pose) for shape, pose in placed}
        upright = [each for each in stands.values() if each]
        self._light = light
        self._painters: dict[Rgb, Painter] = {}
        self.floors = sorted((each for each in upright if each.high <= FLOOR_M), key=lambda each: -each.high)
        self.obstacles = [each for each in upright if each.high > FLOOR_M]
        self.solids = Solids(placed)
        self._is_paintable = all(each and (each in self.floors or _is_on_floor(each)) for each in stands.values())

    def painter(self, sky: Rgb) -> Painter | None:
        """Return what paints it before a sky, where everything stands on the floor; else None, and rays must do."""
        if not self._is_paintable:
            return None
        if sky not in self._painters:
            self._painters[sky] = Painter(self.described(self.obstacles, sky))
        return self._painters[sky]

    def between(self, low: float, high: float) -> list[Standing]:
        """Return the obstacles that something between two heights may run into: boxes and cylinders, then balls."""
        reached = [each for each in self.obstacles if each.low < high and each.high > low]
        return sorted(reached, key=lambda each: isinstance(each.thing, Ball))

    def described(self, obstacles: Iterable[Standing], sky: Rgb = (0, 0, 0)) -> WorldDescription:
        """Return the description of a world of these; where there is no floor, one looks into the sky."""
        things = [each.thing for each in obstacles]
        return WorldDescription.model_construct(
            name="scene",
            floor=Floor.model_construct(length_m=100.0, width_m=100.0, colour=self._ground or sky),
            light=self._light.model_copy(update={"sky_colour": sky}),
            obstacles=tuple(thing for thing in things if not isinstance(thing, Ball)),
            targets=tuple(thing for thing in things if isinstance(thing, Ball)),
        )

    @property
    def _ground(self) -> Rgb | None:
        """The colour of the highest floor."""
        return self.floors[0].thing.colour if self.floors else None


def _shown(graph: Graph, entity: int) -> list[Shape]:
    """Return the shapes of a collection, or all."""
    if entity == ALL_THERE_IS:
        return graph.all_of(Shape)
    members = graph.collections[entity].members(graph)
    return [shape for shape in graph.all_of(Shape) if shape in members]


def _is_on_floor(each: Standing) -> bool:
    return each.low <= FLOOR_M and (not isinstance(each.thing, Ball) or each.low >= -FLOOR_M)


Array = NDArray[np.float64]

LEVEL = 1e-6
"""The painter's cameras have no roll: their rows are level to this."""

EMPTY = 1.63e-5
"""Where nothing is in view, a depth ends short of ``far`` by this part of the range, as recorded."""


def view_of(sensor: VisionSensor, pose: Transform) -> CameraView:
    """Return the view of a sensor that looks along its z, with y upwards and x to the left."""
    left, up, ahead = (np.array(axis) for axis in pose.axes)
    return CameraView(intrinsics_of(sensor), np.array(pose.position), np.array((-left, -up, ahead)))


def intrinsics_of(sensor: VisionSensor) -> Intrinsics:
    """Return them; the sensor's angle is across the longer side of its picture."""
    wide = math.tan(sensor.angle / 2) * min(1.0, sensor.width / sensor.height)
    return Intrinsics(sensor.width, sensor.height, 2 * math.atan(wide))


class Exposure:
    """What a sensor saw of a scenery from a place, reckoned when somebody asks: row 0 at the bottom."""

    def __init__(self, sensor: VisionSensor, pose: Transform, scenery: Scenery, light: Light) -> None:
        self._sensor, self._pose, self._scenery = sensor, pose, scenery
        self._light = light.model_copy(update={"sky_colour": _sky(sensor, light)})

    @cached_property
    def picture(self) -> Pixels:
        """Red, green and blue, (height, width, 3)."""
        view = view_of(self._sensor, self._pose)
        painter = self._scenery.painter(self._light.sky_colour) if abs(view.rotation[0, 2]) < LEVEL else None
        if painter:
            return painter.picture(view)[::-1, :, ::-1]
        return _cast(view, self._sensor, self._scenery, self._light)

    @cached_property
    def depths(self) -> Depths:
        """How far it saw along its optical axis, (height, width), in metres."""
        return self.depths_of_every(1)

    def depths_of_every(self, nth: int) -> Depths:
        """Return how far it saw in every so-many-th pixel of every so-many-th row."""
        sensor, view = self._sensor, view_of(self._sensor, self._pose)
        rays = _directions(view, nth)
        lengths = self._scenery.solids.cast(view.eye, rays.reshape(-1, 3))
        empty = sensor.far - EMPTY * (sensor.far - sensor.near)
        lengths = np.where((lengths >= sensor.near) & (lengths <= sensor.far), lengths, empty)
        return lengths.reshape(rays.shape[:2]).astype(np.float32)


@dataclass(frozen=True)
class Blank:
    """What a sensor shows that was never rendered, or was given a picture."""

    picture: Pixels
    depths: Depths

    @classmethod
    def of(cls, sensor: VisionSensor, picture: Pixels | None = None) -> Blank:
        """Return black where there is no picture, and depths of exactly ``far``."""
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


def _cast(view: CameraView, sensor: VisionSensor, scenery: Scenery, light: Light) -> Pixels:
    """Return the picture from the lowest row up, a ray a pixel."""
    hits = scenery.solids.hits(view.eye, _directions(view).reshape(-1, 3))
    is_seen = (hits.lengths >= sensor.near) & (hits.lengths <= sensor.far)
    colours = np.where(is_seen[:, None], _lit(hits, scenery, light), light.sky_colour)
    return np.rint(colours).astype(np.uint8).reshape(sensor.height, sensor.width, 3)


def _lit(hits: Hits, scenery: Scenery, light: Light) -> Array:
    """Return the colours of what is hit, (n, 3), shaded as the painter does it."""
    palette = 255 * np.array([shape.colour for shape in scenery.solids.shapes] or [(0.0, 0.0, 0.0)])
    cosines = np.maximum(hits.normals @ np.array(light.direction), 0.0)
    shade = np.minimum(light.ambient + light.diffuse * cosines, 1.0) * light.brightness
    return np.asarray(np.minimum(palette[hits.solids] * shade[:, None], 255.0))


def _directions(view: CameraView, nth: int = 1) -> Array:
    """Return the rays through the middles of every nth pixel, (rows, columns, 3), one metre deep; row 0 lowest."""
    i = view.intrinsics
    right = (np.arange(0, i.width, nth) - i.cx) / i.focal_length
    down = (np.arange(i.height - 1, -1, -nth) - i.cy) / i.focal_length
    across, along = view.rotation[0] * right[:, None], view.rotation[1] * down[:, None]
    return np.asarray(across[None] + along[:, None] + view.rotation[2])
