"""What does not move by itself: the floor, and all that a robot may drive against or a sensor see."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import cached_property

from drivers.kinematic.painter import Painter
from robotcore.description import Ball, Floor, Light, WorldDescription
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Shape, Thing
from tests.doubles.coppeliasim.scene.rays import Solids
from tests.doubles.coppeliasim.scene.standing import Standing, standing

FLOOR_M = 0.01
"""What ends below this is floor; what begins below it stands on the floor."""


class Scenery:
    """The shapes of a scene without its robots, as they are now. Made anew when somebody changes the scene.

    Tilted shapes are seen and ranged, and nothing is blocked by them.
    """

    def __init__(self, graph: Graph, robots: Collection[Thing], light: Light) -> None:
        placed = [(shape, graph.pose(shape)) for shape in graph.all_of(Shape) if shape not in robots]
        stands = {shape: standing(shape, pose) for shape, pose in placed}
        upright = [each for each in stands.values() if each]
        self._light = light
        self.floors = [each for each in upright if each.high <= FLOOR_M]
        self.obstacles = [each for each in upright if each.high > FLOOR_M]
        self.solids = Solids(placed)
        self._is_paintable = all(each and (each in self.floors or _is_on_floor(each)) for each in stands.values())

    @cached_property
    def painter(self) -> Painter | None:
        """Paints it, where everything stands on the floor; else None, and rays must do."""
        return Painter(self.described(self.obstacles)) if self._is_paintable else None

    def between(self, low: float, high: float) -> list[Standing]:
        """Return the obstacles that something between two heights may run into: boxes and cylinders, then balls."""
        reached = [each for each in self.obstacles if each.low < high and each.high > low]
        return sorted(reached, key=lambda each: isinstance(each.thing, Ball))

    def described(self, obstacles: Iterable[Standing]) -> WorldDescription:
        """Return the description of a world of these."""
        things = [each.thing for each in obstacles]
        return WorldDescription.model_construct(
            name="scene",
            floor=Floor.model_construct(length_m=100.0, width_m=100.0, colour=self._ground),
            light=self._light,
            obstacles=tuple(thing for thing in things if not isinstance(thing, Ball)),
            targets=tuple(thing for thing in things if isinstance(thing, Ball)),
        )

    @property
    def _ground(self) -> tuple[int, int, int]:
        """The colour of the largest floor; where there is none, one looks into the background."""
        largest = max(self.floors, key=lambda each: each.shape.size[0] * each.shape.size[1], default=None)
        return largest.thing.colour if largest else self._light.sky_colour


def _is_on_floor(each: Standing) -> bool:
    return each.low <= FLOOR_M and (not isinstance(each.thing, Ball) or each.low >= -FLOOR_M)
