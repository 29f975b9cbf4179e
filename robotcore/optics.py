"""The pinhole model of a camera: intrinsics, and the projection of points of the world to pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose

__all__ = ["CameraView", "Image", "Intrinsics", "is_picture"]

Image = NDArray[np.uint8]
"""A BGR picture of shape (height, width, 3), or a grey one of shape (height, width), as ``uint8``.

The origin is the top left corner.
"""


Array = NDArray[np.float64]

MAX_SLOPE = 6.0
"""The greatest slope of a ray to the optical axis that a lens shows, along the rows and along the columns: 80°."""

UNDISTORT_STEPS = 60
"""The number of steps of `Intrinsics.undistort`."""


def is_picture(value: object) -> bool:
    """Return whether a value is an `Image` with at least one pixel.

    >>> import numpy as np
    >>> is_picture(np.zeros((240, 320, 3), np.uint8)), is_picture(np.zeros((240, 320)))
    (True, False)
    """
    if not isinstance(value, np.ndarray) or value.dtype != np.uint8 or not value.size:
        return False
    return value.ndim == 2 or (value.ndim == 3 and value.shape[2] == 3)


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """The pinhole model of a camera with square pixels, and the distortion of its lens.

    The centres of pixels have whole coordinates, as in OpenCV. The optical axis is at the pixel ``(cx, cy)``.

    >>> import math
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
    """The full horizontal field of view of a lens without distortion, whose axis is in the middle, in radians."""
    centre: tuple[float, float] | None = None
    """The column and the row of the optical axis, in pixels. None: the axis is in the middle of the picture."""
    distortion: tuple[float, ...] = ()
    """The coefficients k1, k2, p1, p2 and k3 of the lens; empty without distortion.

    Source: https://docs.opencv.org/4.x/d9/d0c/group__calib3d.html.
    """

    @property
    def focal_length(self) -> float:
        """The focal length in pixels."""
        return self.width / 2 / math.tan(self.horizontal_fov / 2)

    @property
    def cx(self) -> float:
        """The column of the optical axis in a picture, in pixels."""
        return self.centre[0] if self.centre else (self.width - 1) / 2

    @property
    def cy(self) -> float:
        """The row of the optical axis in a picture, in pixels."""
        return self.centre[1] if self.centre else (self.height - 1) / 2

    @property
    def is_pinhole(self) -> bool:
        """Whether the optical axis is in the middle and the lens does not distort."""
        return self.centre is None and not self.distortion

    def bearing(self, u: float, v: float | None = None) -> float:
        """Return the direction of a point of a picture in radians, positive to the left of the optical axis.

        u: the column of the point.
        v: the row of the point, which counts if the lens distorts; None for that of the optical axis.
        """
        if self.distortion:
            u = float(self.undistort(np.array([[u, self.cy if v is None else v]]))[0, 0])
        return math.atan2(self.cx - u, self.focal_length)

    def distort(self, pixels: Array) -> Array:
        """Return the pixels at which the lens shows points that a pinhole would show at ``pixels``, both (n, 2)."""
        if not self.distortion:
            return pixels
        x, y = self._to_slopes(pixels)
        return self._to_pixels(*self._bend(x, y))

    def undistort(self, pixels: Array) -> Array:
        """Return the pixels at which a pinhole would show points that the lens shows at ``pixels``, both (n, 2).

        The method is a fixed-point iteration. It converges for lenses whose distortion grows with the angle.
        """
        if not self.distortion:
            return pixels
        bent_x, bent_y = x, y = self._to_slopes(pixels)
        for _ in range(UNDISTORT_STEPS):
            there_x, there_y = self._bend(x, y)
            x = np.clip(x + bent_x - there_x, -MAX_SLOPE, MAX_SLOPE)
            y = np.clip(y + bent_y - there_y, -MAX_SLOPE, MAX_SLOPE)
        return self._to_pixels(x, y)

    def _bend(self, x: Array, y: Array) -> tuple[Array, Array]:
        k1, k2, p1, p2, k3 = self.distortion
        square = x * x + y * y
        radial = 1 + square * (k1 + square * (k2 + square * k3))
        return (
            x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x),
            y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y,
        )

    def _to_slopes(self, pixels: Array) -> tuple[Array, Array]:
        return (pixels[:, 0] - self.cx) / self.focal_length, (pixels[:, 1] - self.cy) / self.focal_length

    def _to_pixels(self, x: Array, y: Array) -> Array:
        return np.stack((x, y), axis=1) * self.focal_length + (self.cx, self.cy)


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

    >>> import numpy as np
    >>> from robotcore import Pose
    >>> from robotcore.description import load_robot
    >>> from robotcore.kinds.camera import CameraDescription
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
        return i.distort(points[:, :2] * (i.focal_length / points[:, 2:]) + (i.cx, i.cy))

    def shows(self, points: Array) -> NDArray[np.bool_]:
        """Return for each point whether it is in the field of view, shape (n,). Obstacles are ignored.

        points: points in the world's frame, in metres, shape (n, 3).
        """
        local = self.to_camera(points)
        if not self.intrinsics.is_pinhole:
            return self._shows_through_lens(local)
        depth = np.maximum(local[:, 2], 1e-9)
        half_width = self.intrinsics.width / 2 / self.intrinsics.focal_length
        half_height = self.intrinsics.height / 2 / self.intrinsics.focal_length
        inside: NDArray[np.bool_] = (
            (local[:, 2] > 0)
            & (np.abs(local[:, 0]) <= half_width * depth)
            & (np.abs(local[:, 1]) <= half_height * depth)
        )
        return inside

    def _shows_through_lens(self, local: Array) -> NDArray[np.bool_]:
        i = self.intrinsics
        edge = np.array([(u, v) for u in (-0.5, i.cx, i.width - 0.5) for v in (-0.5, i.cy, i.height - 0.5)])
        limit = np.abs(i.undistort(edge) - (i.cx, i.cy)).max(axis=0)  # beyond it, the model of the lens is not valid
        flat = local[:, :2] * (i.focal_length / np.maximum(local[:, 2:], 1e-9))
        u, v = i.distort(np.clip(flat, -limit, limit) + np.array((i.cx, i.cy))).T
        is_inside = (u >= -0.5) & (u <= i.width - 0.5) & (v >= -0.5) & (v <= i.height - 0.5)
        return np.asarray((local[:, 2] > 0) & (np.abs(flat) <= limit).all(axis=1) & is_inside)
