"""How a scene was when the simulation started, so that it is so again after the stop."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import Joint, VisionSensor


class Initial:
    """Places, joints and parents of a scene. What is made later is gone when it is restored."""

    def __init__(self, graph: Graph) -> None:
        self._places = {thing: (thing.parent, thing.local) for thing in graph}
        self._joints = {joint: (joint.position, joint.target_velocity) for joint in graph.all_of(Joint)}
        self._explicit = {sensor: sensor.explicit for sensor in graph.all_of(VisionSensor)}

    def restore(self, graph: Graph) -> None:
        """Put everything back."""
        for thing in list(graph):
            if thing not in self._places:
                graph.remove(thing)
        for thing in graph:
            parent, local = self._places[thing]
            if thing.parent is not parent and (parent is None or parent.handle in graph):
                graph.move_under(thing, parent, in_place=False)
            thing.local = local
        for joint in graph.all_of(Joint):
            joint.position, joint.target_velocity = self._joints[joint]
            joint.velocity = 0.0
        for sensor in graph.all_of(VisionSensor):
            sensor.explicit = self._explicit[sensor]
        graph.revision += 1
