"""The pinhole model of a camera: intrinsics, and the projection of points of the world to pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose

Image = NDArray[np.uint8]
"""A BGR picture of shape (height, width, 3), or a grey one of shape (height, width), as ``uint8``.

The origin is the top left corner.
"""


def is_picture(value: object) -> bool:
    """Return whether a value is an `Image` with at least one pixel.

    >>> is_picture(np.zeros((240, 320, 3), np.uint8)), is_picture(np.zeros((240, 320)))
    (True, False)
    """
    if not isinstance(value, np.ndarray) or value.dtype != np.uint8 or not value.size:
        return False
    return value.ndim == 2 or (value.ndim == 3 and value.shape[2] == 3)


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """The pinhole model of a camera with square pixels.

    The centres of pixels have whole coordinates, as in OpenCV. The optical axis is at the pixel ``(cx, cy)``.

    >>> eye = Intrinsics(width=320, height=240, horizontal_fov=math.radians(60))
    >>> round(eye.focal_length, 1), eye.cx
    (277.1, 159.5)
    >>> round(math.degrees(eye.bearing(0)), 1)  # the leftmost column
    29.9
    """

    width: int
    """The width of a picture, in pixels."""
    height: int
    """The height of a picture, in pixels."""
    horizontal_fov: float
    """The full horizontal field of view, in radians."""

    @property
    def focal_length(self) -> float:
        """The focal length in pixels."""
        return self.width / 2 / math.tan(self.horizontal_fov / 2)

    @property
    def cx(self) -> float:
        """The column of the optical axis in a picture, in pixels."""
        return (self.width - 1) / 2

    @property
    def cy(self) -> float:
        """The row of the optical axis in a picture, in pixels."""
        return (self.height - 1) / 2

    def bearing(self, u: float) -> float:
        """Return the direction of the column ``u`` in radians, positive to the left of the optical axis."""
        return math.atan2(self.cx - u, self.focal_length)


Array = NDArray[np.float64]


class Mounted(Protocol):
    """The position and the direction of a sensor in the robot's frame.

    A positive yaw points to the left, and a positive pitch points down.
    """

    @property
    def x_m(self) -> float: ...
    @property
    def y_m(self) -> float: ...
    @property
    def z_m(self) -> float: ...
    @property
    def yaw_rad(self) -> float: ...
    @property
    def pitch_rad(self) -> float: ...


@dataclass(frozen=True, eq=False)
class CameraView:
    """Projects points of the world to the pixels of a camera at a fixed pose.

    >>> from robotcore.kinds.camera import CameraDescription
    >>> from robotcore.description import load_robot
    >>> eye = load_robot("rover").first_of(CameraDescription)
    >>> view = CameraView.of(eye.intrinsics, eye.mount, Pose(0.0, 0.0, 0.0))
    >>> point = np.array([[1.14, 0.0, 0.1]])  # 1 m ahead of the camera
    >>> view.to_pixels(view.to_camera(point)).tolist(), view.shows(point).tolist()
    ([[159.5, 119.5]], [True])
    """

    intrinsics: Intrinsics
    eye: Array
    """The camera's position in the world, in metres, shape (3,)."""
    rotation: Array
    """The camera's axes right, down and forward as unit vectors in the world's frame, one per row, shape (3, 3)."""

    @classmethod
    def of(cls, intrinsics: Intrinsics, mount: Mounted, pose: Pose) -> CameraView:
        """Return the view of a camera on a robot.

        intrinsics: the pinhole model of the camera.
        mount: the camera's position and direction on the robot.
        pose: the robot's pose in the world.
        """
        x, y = pose.to_world(mount.x_m, mount.y_m)
        yaw, pitch = pose.heading + mount.yaw_rad, mount.pitch_rad
        cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
        right, down, forward = (sy, -cy, 0.0), (-sp * cy, -sp * sy, -cp), (cp * cy, cp * sy, -sp)
        return cls(intrinsics, np.array((x, y, mount.z_m)), np.array((right, down, forward)))

    def to_camera(self, points: Array) -> Array:
        """Convert points from the world's frame to the camera's frame, both of shape (n, 3) in metres.

        The axes of the camera's frame point right, down and forward.
        """
        return np.asarray((points - self.eye) @ self.rotation.T)

    def to_pixels(self, points: Array) -> Array:
        """Return the column and the row of each point in the picture, shape (n, 2).

        points: points in the camera's frame, ahead of the camera, in metres, shape (n, 3).
        """
        i = self.intrinsics
        return points[:, :2] * (i.focal_length / points[:, 2:]) + (i.cx, i.cy)

    def shows(self, points: Array) -> NDArray[np.bool_]:
        """Return for each point whether it is in the field of view, shape (n,). Obstacles are ignored.

        points: points in the world's frame, in metres, shape (n, 3).
        """
        local = self.to_camera(points)
        depth = np.maximum(local[:, 2], 1e-9)
        half_width = self.intrinsics.width / 2 / self.intrinsics.focal_length
        half_height = self.intrinsics.height / 2 / self.intrinsics.focal_length
        inside: NDArray[np.bool_] = (
            (local[:, 2] > 0)
            & (np.abs(local[:, 0]) <= half_width * depth)
            & (np.abs(local[:, 1]) <= half_height * depth)
        )
        return inside
