"""Where things are: a pose as the API has it, metres and a quaternion (x, y, z, w), and poses put together."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from robotcore.description import Light, Mount
from robotcore.geometry import Pose


class Placement(NamedTuple):
    """A frame in the world, or in another frame."""

    x: float
    y: float
    z: float
    qx: float = 0.0
    qy: float = 0.0
    qz: float = 0.0
    qw: float = 1.0

    @classmethod
    def of(cls, told: Any) -> Placement:
        """Return the pose that the API tells; raises TypeError or ValueError where it is none."""
        x, y, z, qx, qy, qz, qw = map(float, told)
        return cls(x, y, z, qx, qy, qz, qw)

    def at(self, local: Placement) -> Placement:
        """Return in the world what is ``local`` in this frame."""
        x, y, z = self._turned(local.x, local.y, local.z)
        return Placement(self.x + x, self.y + y, self.z + z, *_product(self[3:], local[3:]))

    def _turned(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        inverse = (-self.qx, -self.qy, -self.qz, self.qw)
        turned = _product(_product(self[3:], (x, y, z, 0.0)), inverse)
        return turned[0], turned[1], turned[2]


Quaternion = tuple[float, ...]

AXLE = Placement(0.0, 0.0, 0.0, -math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Its z axis points to the robot's left: a joint that turns forward."""

LOOK = Placement(0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5)
"""Its z axis points forward, x to the left, y up: a sensor that looks ahead, upright."""


def on_floor(pose: Pose) -> Placement:
    """Return the frame of a pose in plan."""
    return Placement(pose.x, pose.y, 0.0, *_about_z(pose.heading))


def mounted(mount: Mount, behind_m: float = 0.0) -> Placement:
    """Return the frame of a sensor that looks as its mount says, begun so far behind it, in the robot's frame."""
    half = mount.pitch_rad / 2
    turn = _product(_about_z(mount.yaw_rad), (0.0, math.sin(half), 0.0, math.cos(half)))
    frame = Placement(mount.x_m, mount.y_m, mount.z_m, *turn)
    return frame.at(LOOK._replace(x=-behind_m))


def shining(light: Light) -> Placement:
    """Return the frame of a lamp, high above, whose z axis points where its light goes."""
    tilt = -math.pi / 2 - light.elevation_rad
    turn = _product(_about_z(light.azimuth_rad), (0.0, math.sin(tilt / 2), 0.0, math.cos(tilt / 2)))
    return Placement(0.0, 0.0, 3.0, *turn)


def _about_z(angle: float) -> Quaternion:
    return 0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
