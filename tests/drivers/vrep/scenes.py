"""The scenes of the tutorials, and the conformance kit on the double."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace

import pytest

from drivers.vrep.backend import VrepBackend
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.testing import worlds
from robotcore.testing.bench import TestBench
from tests.doubles.coppeliasim.legacy.recorded import AHEAD, TO_THE_LEFT
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import (
    Joint,
    JointMode,
    Primitive,
    ProximitySensor,
    Shape,
    VisionSensor,
)
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scenes import described_scene

WIDTH, HEIGHT = 320, 240


def bubblerob_scene(wall_m: float = 0.6) -> Simulator:
    """Return a scene with bubbleRob in its old names, in front of a wall.

    wall_m: the distance from its axle to the wall.
    """
    graph = Graph()
    graph.put(graph.add(Shape("floor", size=(9.0, 9.0, 0.1))), Transform((0.0, 0.0, -0.05)))
    graph.put(graph.add(Shape("wall", size=(0.1, 4.0, 0.6))), Transform((wall_m + 0.05, 0.0, 0.3)))
    body = graph.add(
        Shape("bubbleRob", primitive=Primitive.SPHEROID, size=(0.2, 0.2, 0.2), is_static=False, is_respondable=True)
    )
    graph.put(body, Transform((-0.05, 0.0, 0.12)))
    for name, y in (("left", 0.1), ("right", -0.1)):
        joint = graph.add(Joint(f"{name}Motor", control=JointMode.VELOCITY), body)
        joint.flat_name = f"bubbleRob_{name}Motor"
        wheel = graph.add(
            Shape(f"{name}Wheel", primitive=Primitive.CYLINDER, size=(0.08, 0.08, 0.03), is_static=False), joint
        )
        for node in (joint, wheel):
            graph.put(node, Transform((0.0, y, 0.04), TO_THE_LEFT))
    nose = graph.add(ProximitySensor("sensingNose", reach=0.25), body)
    nose.flat_name = "bubbleRob_sensingNose"
    graph.put(nose, Transform((0.05, 0.0, 0.12), AHEAD))
    return Simulator(graph)


def relay_scene() -> Simulator:
    """Return a scene with v0, which sees a green ball on the left, and v1, which shows received pictures."""
    graph = Graph()
    graph.put(graph.add(Shape("floor", size=(9.0, 9.0, 0.1))), Transform((0.0, 0.0, -0.05)))
    ball = graph.add(Shape("ball", primitive=Primitive.SPHEROID, size=(0.2, 0.2, 0.2), colour=(0.0, 1.0, 0.0)))
    graph.put(ball, Transform((1.0, 0.2, 0.1)))
    eye = graph.add(VisionSensor("v0", width=WIDTH, height=HEIGHT))
    graph.put(eye, Transform((0.0, 0.0, 0.2), AHEAD))
    graph.add(VisionSensor("v1", width=WIDTH, height=HEIGHT, takes_external_pictures=True))
    return Simulator(graph)


class LegacyBench(TestBench):
    """A test bench with a new server for each robot."""

    backend = VrepBackend
    servers: ExitStack

    @pytest.fixture(autouse=True)
    def _close_servers(self) -> Iterator[None]:
        with ExitStack() as self.servers:
            yield

    def open(self, setup: Setup) -> Robot:
        simulator = described_scene(self.description, setup.world or worlds.empty())
        return super().open(replace(setup, options={**self.serve(simulator), **setup.options}))

    def serve(self, simulator: Simulator) -> dict[str, object]:
        """Start a server of a scene, and return the backend options with its port."""
        return {"port": self.servers.enter_context(LegacyServer(simulator)).port}
