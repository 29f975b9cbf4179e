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
"""The x, y and z components of a position in metres, or of a velocity in m/s."""


class ObjectKind(str, Enum):
    """The kinds of scene objects."""

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
    """The number by which the server identifies the object."""
    path: str
    """The path in the tree of objects, such as ``/rover/leftMotor``. In a scene without paths, the object's name."""
    kind: ObjectKind


class CameraOptics(NamedTuple):
    """The resolution and the field of view of a vision sensor."""

    width: int
    """The number of columns of the picture."""
    height: int
    """The number of rows of the picture."""
    horizontal_fov: float | None
    """The horizontal field of view in radians; None if the server does not report it."""


class RawPicture(NamedTuple):
    """A picture in the layout of the simulators."""

    pixels: bytes | memoryview
    """Red, green and blue of each pixel, one byte each. The first row is the lowest one."""
    width: int
    """The number of columns."""
    height: int
    """The number of rows."""


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
    """A scene of a simulator that is reached over a connection.

    If the simulation runs without lockstep, several threads may call the methods at the same time.

    Each method raises BackendError if the server has ended, hangs, or sends an invalid answer. After one call has timed
    out, each further call fails at once.
    """

    @abstractmethod
    def find(self, path: str) -> SceneObject | None:
        """Return the object with this path, or with this name if the scene has no paths; None if there is none."""

    @abstractmethod
    def list_objects(self) -> Sequence[SceneObject]:
        """Return all objects of the scene."""

    @abstractmethod
    def read_state(self) -> State:
        """Return the state of the simulation."""

    @abstractmethod
    def start(self) -> None:
        """Start the simulation if it is stopped. In lockstep, its time then advances only by calls of `advance`.

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
        """Simulate time steps in lockstep. Later reads return the state at the end of the last step.

        steps: the number of time steps.

        Raises BackendError if the simulation's time did not advance by these steps, because it was paused or stopped.
        """

    @abstractmethod
    def set_joint_velocity(self, joint: int, rad_s: float) -> None:
        """Set the target velocity of a joint, in rad/s."""

    @abstractmethod
    def read_joint_position(self, joint: int) -> float:
        """Return the angle of a joint in radians. If the joint has no limits, the angle is between -π and π."""

    @abstractmethod
    def detect(self, sensor: int) -> Point | None:
        """Return the point that a proximity sensor detects, in the sensor's frame; None if it detects nothing."""

    def diagnose_sensor(self, sensor: int) -> str | None:
        """Return a sentence with the problem of a proximity sensor and one with the remedy; None if the sensor works.

        The caller must not have started the simulation. Some servers do not simulate proximity sensors, and report no
        detection. Then the app would see no obstacles.
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
        """Show a picture on a vision sensor. The picture must have the resolution of the sensor."""

    @abstractmethod
    def read_position(self, handle: int) -> Point:
        """Return the position of an object in the world, in metres."""

    @abstractmethod
    def read_velocity(self, handle: int) -> Point:
        """Return the velocity of an object in the world over the last time step, in m/s.

        The caller must have called `read_position` for the object before.
        """

    @abstractmethod
    def close(self) -> None:
        """Disconnect from the server. A second call does nothing. If the server has ended, no error is raised."""
