"""The light of a scene, and the world that moves the robots of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robotcore.description import Light
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Joint, Lamp, Node, ProximitySensor, VisionSensor
from tests.doubles.coppeliasim.scene.outlines import Contact
from tests.doubles.coppeliasim.scene.poses import Vector
from tests.doubles.coppeliasim.scene.rays import Detection, detect
from tests.doubles.coppeliasim.scene.rendering import ALL_THERE_IS, RenderedPicture, Scenery
from tests.doubles.coppeliasim.scene.rover import Rover, find_drives

DEFAULT_LIGHT = Light(elevation_rad=math.pi / 2, ambient=0.57, diffuse=0.38, sky_colour=(0, 0, 0))
"""The light of the recorded pictures: from above, with a black background."""


@dataclass
class SceneLight:
    """The light of a scene until a client sets a lamp."""

    light: Light = DEFAULT_LIGHT

    def select_light(self, graph: Graph) -> Light:
        """Return the light of the scene. If a client has set a lamp, it is the light of the first lamp that is on."""
        lamps = [lamp for lamp in graph.all_of(Lamp) if lamp.is_set]
        if not lamps:
            return self.light
        lit = next((lamp for lamp in lamps if lamp.is_on), None)
        return self._convert_lamp(lit, graph) if lit else self.light.model_copy(update={"diffuse": 0.0})

    def _convert_lamp(self, lamp: Lamp, graph: Graph) -> Light:
        x, y, z = graph.pose(lamp).axes[2]
        towards = {"azimuth_rad": math.atan2(-y, -x), "elevation_rad": math.asin(max(-1.0, min(1.0, -z)))}
        return self.light.model_copy(update={**towards, "diffuse": sum(lamp.diffuse) / 3, "brightness": 1.0})


class InitialState:
    """The initial places, joints and parents of a scene. `restore` removes later objects."""

    def __init__(self, graph: Graph) -> None:
        self._places = {node: (node.parent, node.local) for node in graph}
        self._joints = {joint: (joint.position, joint.target_velocity) for joint in graph.all_of(Joint)}
        self._explicit = {sensor: sensor.explicit for sensor in graph.all_of(VisionSensor)}

    def restore(self, graph: Graph) -> None:
        """Restore the scene."""
        for node in list(graph):
            if node not in self._places:
                graph.remove(node)
        for node in graph:
            parent, local = self._places[node]
            if node.parent is not parent and (parent is None or parent.handle in graph):
                graph.move_under(node, parent, in_place=False)
            node.local = local
        for joint in graph.all_of(Joint):
            joint.position, joint.target_velocity = self._joints[joint]
            joint.velocity = 0.0
        for sensor in graph.all_of(VisionSensor):
            sensor.explicit = self._explicit[sensor]
        graph.revision += 1


STANDING: tuple[Vector, Vector] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class World:
    """Moves the robots that the scene had at the start, and renders the static shapes."""

    def __init__(self, graph: Graph, look: SceneLight) -> None:
        self.contacts: list[Contact] = []
        self._graph, self._look = graph, look
        self._rovers: list[Rover] = []
        self._known: dict[int, Scenery] = {}
        self._hidden: set[Node] = set()
        self._revision = -1

    def begin(self, step: float) -> None:
        """Find the robots of the scene. ``step`` is the physics step in seconds."""
        drives = find_drives(self._graph)
        self._rovers = [Rover(drive, self._graph, self.scenery, step) for drive in drives]

    def end(self) -> None:
        self._rovers = []
        self.contacts = []

    def advance(self, count: int) -> None:
        """Simulate ``count`` physics steps."""
        scenery = self.scenery
        for rover in self._rovers:
            rover.advance(count)
        self.contacts = [contact for rover in self._rovers for contact in rover.contacts(scenery)]

    def render(self, sensor: VisionSensor) -> RenderedPicture:
        """Return the present picture of a sensor."""
        return RenderedPicture(
            sensor, self._graph.pose(sensor), self._select_scenery(sensor.entity), self._look.select_light(self._graph)
        )

    def detection(self, sensor: ProximitySensor) -> Detection | None:
        return detect(sensor, self._graph.pose(sensor), self._select_scenery(sensor.entity).solids)

    def velocity(self, node: Node) -> tuple[Vector, Vector]:
        """Return an object's linear and angular velocity in the world, in m/s and rad/s."""
        rover = next((rover for rover in self._rovers if rover.contains(node)), None)
        return rover.velocity(self._graph.pose(node).position) if rover else STANDING

    @property
    def scenery(self) -> Scenery:
        """The present static shapes."""
        return self._select_scenery(ALL_THERE_IS)

    def _select_scenery(self, entity: int) -> Scenery:
        if self._revision != self._graph.revision:
            self._update_scenery()
        if entity not in self._known:
            self._known[entity] = Scenery(self._graph, self._hidden, self._look.select_light(self._graph), entity)
        return self._known[entity]

    def _update_scenery(self) -> None:
        self._revision = self._graph.revision
        self._hidden = set(self._graph.tree([drive.body for drive in find_drives(self._graph)]))
        self._known = {}
        for rover in self._rovers:
            rover.set_scenery(self.scenery)


def count_physics_steps(time_step: float, physics_step: float) -> int:
    """Return the least number of equal physics steps in a time step that are not longer than ``physics_step``."""
    return max(1, math.ceil(time_step / physics_step - 1e-6))
