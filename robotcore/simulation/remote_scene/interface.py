"""The interface between the devices of a remote scene and the protocol of its server.

Units are SI. Handles are the server's own numbers.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

Point = tuple[float, float, float]
"""x, y, z: a position in metres, or a velocity in m/s."""


class ObjectKind(str, Enum):
    """The kinds of scene objects that a device can be bound to."""

    JOINT = "joint"
    PROXIMITY_SENSOR = "proximity sensor"
    VISION_SENSOR = "vision sensor"
    SHAPE = "shape"
    OTHER = "other object"


class SceneObject(NamedTuple):
    """One object of a scene.

    >>> SceneObject(16, "/rover/leftMotor", ObjectKind.JOINT).kind.value
    'joint'
    """

    handle: int
    """The server's number for the object."""
    path: str
    """The object's place in the tree of objects, or its name in an old scene."""
    kind: ObjectKind


class CameraOptics(NamedTuple):
    """The resolution and the field of view of a vision sensor."""

    width: int
    """In pixels."""
    height: int
    """In pixels."""
    horizontal_fov: float | None
    """The horizontal field of view in radians; None if the server does not report it."""


class RawPicture(NamedTuple):
    """A picture in the simulators' layout: RGB, one byte a channel, row by row from the bottom left corner."""

    pixels: bytes | memoryview
    width: int
    """In pixels."""
    height: int
    """In pixels."""


def compute_horizontal_fov(perspective_angle: float, width: int, height: int) -> float:
    """Return the horizontal field of view of a vision sensor, in radians.

    perspective_angle: the angle across the longer side of the picture, in radians.
    width, height: the size of the picture in pixels.

    >>> compute_horizontal_fov(1.0, 256, 128)
    1.0
    >>> round(compute_horizontal_fov(1.0, 128, 256), 3)
    0.533
    """
    if width >= height:
        return perspective_angle
    return 2 * math.atan(math.tan(perspective_angle / 2) * width / height)


class State(str, Enum):
    """The state of a simulation."""

    STOPPED = "stopped"
    RUNNING = "running"
    PAUSED = "paused"


class Scene(ABC):
    """A scene of a simulator, behind a connection.

    If the simulation runs by itself, several threads call the methods: the app's, the clock's and those that poll.

    Each call raises BackendError if the server is gone, hangs, or sends an invalid answer. After one call has timed
    out, each further call fails at once.
    """

    @abstractmethod
    def find(self, path: str) -> SceneObject | None:
        """Return the object with a path, or with a name of an old scene; None if there is none."""

    @abstractmethod
    def list_objects(self) -> Sequence[SceneObject]:
        """Return all objects; error messages suggest paths from this list."""

    @abstractmethod
    def read_state(self) -> State:
        """Return the state of the simulation."""

    @abstractmethod
    def start(self) -> None:
        """Start the simulation, or join the one that runs. In lockstep, time then waits for `advance`.

        Raises BackendError if the simulation does not start.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop the simulation, and return when it has stopped."""

    @abstractmethod
    def read_time_step(self) -> float:
        """Return the simulation's time step in seconds."""

    @abstractmethod
    def read_time(self) -> float:
        """Return the simulation's time in seconds."""

    @abstractmethod
    def advance(self, steps: int) -> None:
        """Simulate this many time steps, in lockstep. Later reads return the state at the end of the last step.

        Raises BackendError if the simulation's time did not advance by these steps: it was paused or stopped.
        """

    @abstractmethod
    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        """Set the target velocity of a joint, in rad/s."""

    @abstractmethod
    def read_joint_position(self, joint: int) -> float:
        """Return the angle of a joint in radians; between -π and π if the joint has no limits."""

    @abstractmethod
    def detect(self, sensor: int) -> Point | None:
        """Return the point that a proximity sensor detects, in the sensor's frame; None if it detects nothing."""

    def diagnose_sensor(self, sensor: int) -> str | None:
        """Return why a proximity sensor does not work, and what to do, in a sentence each; None if it works.

        Some servers answer "nothing" although they do not simulate the sensor: each way would seem free. This is
        called before the simulation starts.
        """
        return None

    @abstractmethod
    def read_optics(self, sensor: int) -> CameraOptics:
        """Return the resolution and the field of view of a vision sensor."""

    @abstractmethod
    def read_picture(self, sensor: int) -> RawPicture:
        """Return the picture of a vision sensor."""

    @abstractmethod
    def show(self, sensor: int, picture: RawPicture) -> None:
        """Show a picture on a vision sensor in place of its own; the sizes must be equal."""

    @abstractmethod
    def read_position(self, handle: int) -> Point:
        """Return the position of an object in the world, in metres."""

    @abstractmethod
    def read_velocity(self, handle: int) -> Point:
        """Return the velocity of an object in the world over the last time step, in m/s.

        `read_position` must have been called for the object before.
        """

    @abstractmethod
    def close(self) -> None:
        """Disconnect from the server. May be called again; raises nothing if the server is gone."""
