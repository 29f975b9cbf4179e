"""What a scene answers, whatever protocol its server speaks. SI units; handles are the server's own numbers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

Point = tuple[float, float, float]


class ObjectKind(str, Enum):
    """What an object of a scene is, as far as a robot cares."""

    JOINT = "joint"
    PROXIMITY_SENSOR = "proximity sensor"
    VISION_SENSOR = "vision sensor"
    SHAPE = "shape"
    OTHER = "other object"


class SceneObject(NamedTuple):
    """One object: the server's number for it, where it is in the tree, and what it is."""

    handle: int
    path: str
    kind: ObjectKind


class CameraOptics(NamedTuple):
    """How a vision sensor sees: pixels, and its horizontal field of view in radians, where the server tells it."""

    width: int
    height: int
    horizontal_fov: float | None


class RawPicture(NamedTuple):
    """Pixels as simulators keep them: RGB, a byte a channel, row by row from the bottom left corner."""

    pixels: bytes | memoryview
    width: int
    height: int


def horizontal_fov(perspective_angle: float, width: int, height: int) -> float:
    """Return the horizontal field of view of a vision sensor. Its perspective angle is that of the longer side."""
    if width >= height:
        return perspective_angle
    return 2 * math.atan(math.tan(perspective_angle / 2) * width / height)


class State(str, Enum):
    """What a simulation does."""

    STOPPED = "stopped"
    RUNNING = "running"
    PAUSED = "paused"


class Scene(ABC):
    """A scene behind a connection.

    One whose time is followed, not stepped, is called by several threads: the app's, the clock's, and those that poll.
    Every call raises BackendError, with what was asked and of whom, where the server is gone, hangs, or answers what
    it must not; after one that has waited in vain, all fail at once.
    """

    @abstractmethod
    def find(self, path: str) -> SceneObject | None:
        """Return the object at a path, or of a flat name of old scenes; None where there is none."""

    @abstractmethod
    def objects(self) -> Sequence[SceneObject]:
        """Return all objects, for whoever looks for the right path."""

    @abstractmethod
    def state(self) -> State:
        """Return what the simulation does now."""

    @abstractmethod
    def start(self) -> None:
        """Start the simulation, or join the one that runs; in lockstep, time then stands until `advance`.

        Raises BackendError where the simulation does not begin to run.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop the simulation, and return when it has stopped."""

    @abstractmethod
    def time_step(self) -> float:
        """Return the simulation's time step in seconds."""

    @abstractmethod
    def time(self) -> float:
        """Return the simulation's time in seconds."""

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Let so many time steps pass, in lockstep; what is read then is of the end of the last.

        Raises BackendError where time did not move by so much: somebody has paused or stopped the simulation.
        """

    @abstractmethod
    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        """Give a joint its target velocity."""

    @abstractmethod
    def joint_position(self, joint: int) -> float:
        """Return a joint's angle in radians; of one that turns round and round, between -π and π."""

    @abstractmethod
    def detect(self, sensor: int) -> Point | None:
        """Return the point that a proximity sensor detects, in its own frame; None where it detects nothing."""

    def why_unreliable(self, sensor: int) -> str | None:
        """Return why a proximity sensor cannot be believed where it detects nothing; None where it can.

        For servers that answer so although they do not look: the way would seem free. A sentence, and what to do. Asked
        before the simulation is started.
        """
        return None

    @abstractmethod
    def optics(self, sensor: int) -> CameraOptics:
        """Return how a vision sensor sees."""

    @abstractmethod
    def picture(self, sensor: int) -> RawPicture:
        """Return what a vision sensor sees."""

    @abstractmethod
    def show(self, sensor: int, picture: RawPicture) -> None:
        """Let a vision sensor show a picture, of its own size, in place of what it sees."""

    @abstractmethod
    def position(self, handle: int) -> Point:
        """Return where an object is in the world, in metres."""

    @abstractmethod
    def velocity(self, handle: int) -> Point:
        """Return how an object moved in the world in the last time step, in m/s, one whose `position` was asked."""

    @abstractmethod
    def close(self) -> None:
        """Leave the server. May be called again; raises nothing where the server is gone."""
