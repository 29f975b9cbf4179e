"""What a scene tells of where a robot is: by the joints of its two wheels."""

from __future__ import annotations

import math

from robotcore.geometry import Pose, Twist
from robotcore.simulation.remote_scene.port import Point, Scene


class SceneTruth:
    """The robot is where the middle of its axle is, and looks square to it. Touches are not told."""

    def __init__(self, scene: Scene, left: int, right: int) -> None:
        self._scene, self._left, self._right = scene, left, right
        self.pose()  # from now on velocities are known too

    def pose(self) -> Pose:
        left, right = self._wheels()
        return Pose((left[0] + right[0]) / 2, (left[1] + right[1]) / 2, _heading(left, right))

    def twist(self) -> Twist:
        left, right = self._wheels()
        heading = _heading(left, right)
        on_left = _along(self._scene.velocity(self._left), heading)
        on_right = _along(self._scene.velocity(self._right), heading)
        return Twist((on_left + on_right) / 2, (on_right - on_left) / math.dist(left[:2], right[:2]))

    def contacts(self) -> None:
        """Return None: a server that is asked from afar tells too few of them."""

    def _wheels(self) -> tuple[Point, Point]:
        return self._scene.position(self._left), self._scene.position(self._right)


def _heading(left: Point, right: Point) -> float:
    """Return where a robot looks between whose wheels the axle is."""
    return math.atan2(right[0] - left[0], left[1] - right[1])


def _along(velocity: Point, heading: float) -> float:
    return velocity[0] * math.cos(heading) + velocity[1] * math.sin(heading)
