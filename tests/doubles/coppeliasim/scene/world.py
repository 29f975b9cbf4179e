"""The kinematic world behind a scene: its robots and its scenery, found in the graph whenever somebody changes it."""

from __future__ import annotations

import math

from tests.doubles.coppeliasim.scene.contacts import Contact
from tests.doubles.coppeliasim.scene.drives import drives_of
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.look import Look
from tests.doubles.coppeliasim.scene.objects import ProximitySensor, Thing, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Vector
from tests.doubles.coppeliasim.scene.ranging import Detection, detect
from tests.doubles.coppeliasim.scene.rover import Rover
from tests.doubles.coppeliasim.scene.scenery import ALL_THERE_IS, Scenery
from tests.doubles.coppeliasim.scene.seeing import Exposure

STANDING: tuple[Vector, Vector] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class World:
    """Moves what moves, and looks at what stands. Robots are those that the scene had when the simulation began."""

    def __init__(self, graph: Graph, look: Look) -> None:
        self.contacts: list[Contact] = []
        self._graph, self._look = graph, look
        self._rovers: list[Rover] = []
        self._known: dict[int, Scenery] = {}
        self._hidden: set[Thing] = set()
        self._revision = -1

    def begin(self, step: float) -> None:
        """Find the robots; they move in steps of so many seconds."""
        drives = drives_of(self._graph)
        self._rovers = [Rover(drive, self._graph, self.scenery, step) for drive in drives]

    def end(self) -> None:
        self._rovers = []
        self.contacts = []

    def advance(self, count: int) -> None:
        """Take physics steps."""
        scenery = self.scenery
        for rover in self._rovers:
            rover.advance(count)
        self.contacts = [contact for rover in self._rovers for contact in rover.contacts(scenery)]

    def exposed(self, sensor: VisionSensor) -> Exposure:
        """Return what a sensor sees at this instant."""
        return Exposure(sensor, self._graph.pose(sensor), self._seen(sensor.entity), self._look.under(self._graph))

    def detection(self, sensor: ProximitySensor) -> Detection | None:
        return detect(sensor, self._graph.pose(sensor), self._seen(sensor.entity).solids)

    def velocity(self, thing: Thing) -> tuple[Vector, Vector]:
        """Return an object's linear and angular velocity in the world, in m/s and rad/s."""
        rover = next((rover for rover in self._rovers if rover.carries(thing)), None)
        return rover.velocity(self._graph.pose(thing).position) if rover else STANDING

    @property
    def scenery(self) -> Scenery:
        """What stands around, as of now."""
        return self._seen(ALL_THERE_IS)

    def _seen(self, entity: int) -> Scenery:
        """Return what of that belongs to a collection."""
        if self._revision != self._graph.revision:
            self._look_around()
        if entity not in self._known:
            self._known[entity] = Scenery(self._graph, self._hidden, self._look.under(self._graph), entity)
        return self._known[entity]

    def _look_around(self) -> None:
        self._revision = self._graph.revision
        self._hidden = set(self._graph.tree([drive.body for drive in drives_of(self._graph)]))
        self._known = {}
        for rover in self._rovers:
            rover.face(self.scenery)


def physics_steps(time_step: float, physics_step: float) -> int:
    """Return how many physics steps make a time step: the fewest that are no longer than asked for."""
    return max(1, math.ceil(time_step / physics_step - 1e-6))
