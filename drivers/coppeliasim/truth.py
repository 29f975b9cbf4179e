"""What CoppeliaSim knows of the robot, and whom its body touched."""

from __future__ import annotations

import math
from collections.abc import Collection

from drivers.coppeliasim.builder import Placement
from drivers.coppeliasim.connection import Connection
from robotcore.geometry import Pose, Twist


class ContactCounter:
    """Counts the touches of the robot's body with things; one touch is one, however long it lasts.

    Asked after each step, it is told of all physics steps in it. ``patience`` steps without a touch end it: a body that
    leans against a thing is not in contact in each.
    """

    patience = 2

    def __init__(self, connection: Connection, body: int, things: Collection[int]) -> None:
        self.count = 0
        self._connection, self._body, self._things = connection, body, frozenset(things)
        self._all = connection.constant("handle_all")
        self._touched: dict[int, int] = {}

    def look(self) -> None:
        """Note what was touched in the step before."""
        now = self._touching()
        self.count += len(now - self._touched.keys())
        kept = {thing: left - 1 for thing, left in self._touched.items() if left > 1}
        self._touched = kept | dict.fromkeys(now, self.patience)

    def _touching(self) -> set[int]:
        things: set[int] = set()
        for index in range(1000):  # each contact is a call; there is hardly ever one
            pair = self._connection.call_as(_pair, "getContactInfo", self._all, self._body, index)
            if not pair:
                break
            things |= pair & self._things
        return things


class CoppeliaSimTruth:
    """The true state of a robot, whose own frame lies at ``frame`` in its body's."""

    def __init__(self, connection: Connection, body: int, frame: Placement, touches: ContactCounter) -> None:
        self._connection, self._body, self._frame, self._touches = connection, body, frame, touches

    def pose(self) -> Pose:
        origin = self._origin()
        x, y, _ = _ahead(origin)
        return Pose(origin.x, origin.y, math.atan2(y, x))

    def twist(self) -> Twist:
        """Return how the body moves: all of it goes ahead as fast as the axle's middle."""
        linear, angular = self._connection.call_as(_vectors, "getObjectVelocity", self._body)
        forward = _ahead(self._origin())
        return Twist(sum(a * b for a, b in zip(forward, linear, strict=True)), angular[2])

    def contacts(self) -> int:
        return self._touches.count

    def _origin(self) -> Placement:
        return self._connection.call_as(Placement.of, "getObjectPose", self._body).at(self._frame)


def _ahead(frame: Placement) -> tuple[float, float, float]:
    tip = frame._replace(x=0.0, y=0.0, z=0.0).at(Placement(1.0, 0.0, 0.0))
    return tip.x, tip.y, tip.z


def _pair(answer: object) -> set[int]:
    assert isinstance(answer, (list, tuple))
    pair = set(map(int, answer[0]))
    if len(pair) not in (0, 2):
        raise ValueError("no pair of objects")
    return pair


def _vectors(answer: object) -> tuple[list[float], list[float]]:
    assert isinstance(answer, (list, tuple))
    linear, angular = answer
    return list(map(float, linear)), list(map(float, angular))
