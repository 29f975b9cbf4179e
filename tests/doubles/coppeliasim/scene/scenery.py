"""What does not move by itself: the floor, and all that a robot may drive against or a sensor see."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from robotcore.description import Ball, Floor, Light, WorldDescription
from robotcore.simulation.painter import Painter
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Shape, Thing
from tests.doubles.coppeliasim.scene.rays import Solids
from tests.doubles.coppeliasim.scene.standing import Standing, standing

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
