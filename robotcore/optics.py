"""The pinhole camera: intrinsics, and projection between the robot's frame and pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera: size in pixels and horizontal field of view in radians.

    Pixel centres have whole coordinates, as in OpenCV, so the axis meets the picture at ``(cx, cy)``.
    """

    width: int
    height: int
    horizontal_fov: float

    @property
    def focal_length(self) -> float:
        """In pixels; pixels are square."""
        return self.width / 2 / math.tan(self.horizontal_fov / 2)

    @property
    def cx(self) -> float:
        return (self.width - 1) / 2

    @property
    def cy(self) -> float:
        return (self.height - 1) / 2

    def bearing(self, u: float) -> float:
        """Return the direction of column ``u`` in radians, positive to the left."""
        return math.atan2(self.cx - u, self.focal_length)


Array = NDArray[np.float64]


class Mounted(Protocol):
    """Where on a robot something sits and where it looks: metres, and radians to the left and downwards."""

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
    """A camera in the world: the eye, (3,), and the rows right, down, forward of its rotation, (3, 3)."""

    intrinsics: Intrinsics
    eye: Array
    rotation: Array

    @classmethod
    def of(cls, intrinsics: Intrinsics, mount: Mounted, pose: Pose) -> CameraView:
        """Return the view of a camera mounted on a robot at ``pose``."""
        x, y = pose.to_world(mount.x_m, mount.y_m)
        yaw, pitch = pose.heading + mount.yaw_rad, mount.pitch_rad
        cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
        right, down, forward = (sy, -cy, 0.0), (-sp * cy, -sp * sy, -cp), (cp * cy, cp * sy, -sp)
        return cls(intrinsics, np.array((x, y, mount.z_m)), np.array((right, down, forward)))

    def to_camera(self, points: Array) -> Array:
        """Return points of the world, (n, 3), as right, down, forward of the eye, (n, 3)."""
        return np.asarray((points - self.eye) @ self.rotation.T)

    def to_pixels(self, points: Array) -> Array:
        """Return where points ahead of the eye, (n, 3) in camera coordinates, appear: (n, 2)."""
        i = self.intrinsics
        return points[:, :2] * (i.focal_length / points[:, 2:]) + (i.cx, i.cy)

    def shows(self, points: Array) -> NDArray[np.bool_]:
        """Return for each point of the world, (n, 3), whether it lies within the picture, obstacles apart."""
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
