"""The scene of the tutorial with OpenCV: one vision sensor looks at a green ball, another shows what it is given."""

from __future__ import annotations

import math
from functools import partial

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import VisionSensor
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scenes.parts import AHEAD, ball, floor

SIGHT_PX, SIGHT_RAD = 256, math.radians(60)


def relay_scene() -> Simulator:
    """Return it: ``/v0`` looks along x at the ball, ``/v1`` is where the picture goes."""
    graph = Graph()
    graph.add(floor(5.0, 5.0))
    graph.add(ball("ball", 0.1, 1.0, 0.15, (0.15, 0.7, 0.25)))
    sight = partial(VisionSensor, width=SIGHT_PX, height=SIGHT_PX, angle=SIGHT_RAD)
    graph.add(sight("v0", local=Transform((0.0, 0.0, 0.3), AHEAD)))
    graph.add(sight("v1", local=Transform((0.0, 0.0, 3.0)), takes_external_pictures=True))
    return Simulator(graph)
