"""The true pose and velocity of a built robot, and its contacts."""

from __future__ import annotations

import math
from collections.abc import Collection

from drivers.coppeliasim.builder import Placement
from drivers.coppeliasim.connection import SimulatorConnection
from robotcore.geometry import Pose, Twist


class ContactCounter:
    """Counts the contacts of the robot's body with the prisms and balls of the world.

    body: the handle of the robot's body.
    things: the handles of the prisms and balls.

    A contact counts once, however long it lasts. `update` must be called after each time step. It reads the contacts of
    all physics steps of the time step.
    """

    min_gap_steps = 2
    """The number of time steps without touch after which a contact ends.

    A body that leans on an obstacle may lose touch for one time step.
    """

    def __init__(self, connection: SimulatorConnection, body: int, things: Collection[int]) -> None:
        self.count = 0
        self._connection, self._body, self._things = connection, body, frozenset(things)
        self._all = connection.constant("handle_all")
        self._remaining: dict[int, int] = {}

    def update(self) -> None:
        """Count the contacts that began in the last time step."""
        now = self._read_contacts()
        self.count += len(now - self._remaining.keys())
        ongoing = {thing: left - 1 for thing, left in self._remaining.items() if left > 1}
        self._remaining = ongoing | dict.fromkeys(now, self.min_gap_steps)

    def _read_contacts(self) -> set[int]:
        things: set[int] = set()
        for index in range(1000):  # one call for each contact; contacts are rare
            pair = self._connection.call_as(_to_pair, "getContactInfo", self._all, self._body, index)
            if not pair:
                break
            things |= pair & self._things
        return things


class CoppeliaSimTruth:
    """The true pose, velocity and contacts of a built robot.

    body: the handle of the robot's body.
    frame: the robot's frame relative to the frame of the body.
    contacts: counts the contacts of the body.
    """

    def __init__(self, connection: SimulatorConnection, body: int, frame: Placement, contacts: ContactCounter) -> None:
        self._connection, self._body, self._frame, self._contacts = connection, body, frame, contacts

    def pose(self) -> Pose:
        origin = self._origin()
        x, y, _ = _compute_forward(origin)
        return Pose(origin.x, origin.y, math.atan2(y, x))

    def twist(self) -> Twist:
        """Return the velocity of the robot.

        All points on the robot's long axis have the same forward velocity. So the body has the velocity of the axle.
        """
        linear, angular = self._connection.call_as(_to_vectors, "getObjectVelocity", self._body)
        forward = _compute_forward(self._origin())
        return Twist(sum(a * b for a, b in zip(forward, linear, strict=True)), angular[2])

    def contacts(self) -> int:
        return self._contacts.count

    def _origin(self) -> Placement:
        return self._connection.call_as(Placement.from_answer, "getObjectPose", self._body).compose(self._frame)


def _compute_forward(frame: Placement) -> tuple[float, float, float]:
    tip = frame._replace(x=0.0, y=0.0, z=0.0).compose(Placement(1.0, 0.0, 0.0))
    return tip.x, tip.y, tip.z


def _to_pair(answer: object) -> set[int]:
    assert isinstance(answer, (list, tuple))
    pair = set(map(int, answer[0]))
    if len(pair) not in (0, 2):
        raise ValueError(f"has {len(pair)} objects instead of a pair")
    return pair


def _to_vectors(answer: object) -> tuple[list[float], list[float]]:
    assert isinstance(answer, (list, tuple))
    linear, angular = answer
    return list(map(float, linear)), list(map(float, angular))
