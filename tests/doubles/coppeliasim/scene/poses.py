"""Poses in CoppeliaSim's conventions. Quaternions are x, y, z, w. Euler angles are alpha, beta, gamma."""

from __future__ import annotations

import math
from typing import NamedTuple

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class Transform(NamedTuple):
    """A place and an orientation in some frame.

    >>> Transform((1.0, 0.0, 0.0)).apply((0.0, 2.0, 0.0))
    (1.0, 2.0, 0.0)
    """

    position: Vector = (0.0, 0.0, 0.0)
    quaternion: Quaternion = (0.0, 0.0, 0.0, 1.0)

    @classmethod
    def rotated(cls, yaw: float, position: Vector = (0.0, 0.0, 0.0)) -> Transform:
        """Return the transform with a rotation about z by ``yaw`` radians."""
        return cls(position, (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))

    @property
    def pose(self) -> list[float]:
        return [*self.position, *self.quaternion]

    @property
    def axes(self) -> tuple[Vector, Vector, Vector]:
        """The unit vectors of x, y and z in the outer frame."""
        x, y, z, w = self.quaternion
        return (
            (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
            (2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
            (2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)),
        )

    @property
    def yaw(self) -> float:
        """The heading of the x axis in the horizontal plane, in radians."""
        ahead = self.axes[0]
        return math.atan2(ahead[1], ahead[0])

    @property
    def inverse(self) -> Transform:
        x, y, z, w = self.quaternion
        back = Transform((0.0, 0.0, 0.0), (-x, -y, -z, w))
        px, py, pz = back.apply(self.position)
        return Transform((-px, -py, -pz), back.quaternion)

    def apply(self, point: Vector) -> Vector:
        """Transform a point of this frame to the outer frame."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.axes
        (x, y, z), (px, py, pz) = point, self.position
        return (
            px + ax * x + bx * y + cx * z,
            py + ay * x + by * y + cy * z,
            pz + az * x + bz * y + cz * z,
        )

    def compose(self, inner: Transform) -> Transform:
        """Transform a pose in this frame to the outer frame."""
        return Transform(self.apply(inner.position), multiply(self.quaternion, inner.quaternion))


ORIGIN = Transform()


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation ``b`` followed by ``a``."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def normalise(quaternion: Quaternion) -> Quaternion:
    """Normalise a quaternion; one of length zero becomes the identity."""
    x, y, z, w = quaternion
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return (x / norm, y / norm, z / norm, w / norm) if norm else (0.0, 0.0, 0.0, 1.0)


def to_euler(quaternion: Quaternion) -> list[float]:
    """Return the Euler angles alpha, beta and gamma of a rotation, in radians."""
    (xx, _, _), (yx, _, _), (zx, zy, zz) = Transform((0.0, 0.0, 0.0), quaternion).axes
    beta = math.asin(max(-1.0, min(1.0, zx)))
    return [math.atan2(-zy, zz), beta, math.atan2(-yx, xx)]
