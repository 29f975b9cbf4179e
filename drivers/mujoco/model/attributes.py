"""Collision and render groups, orientations and colours, as MuJoCo takes them."""

from __future__ import annotations

import math
from collections.abc import Collection
from enum import IntEnum, IntFlag

import numpy as np

from robotcore.description.devices import Mount


class CollisionGroup(IntFlag):
    """Bits of contype and conaffinity: two geoms meet where one's type is among what the other has an affinity for."""

    NOTHING = 0
    FLOOR = 1
    THING = 2


class RenderGroup(IntEnum):
    """Geom groups. Cameras on a robot see the world alone, its range sensors what stands in it."""

    FLOOR = 0
    WORLD = 1
    ROBOT = 2
    TOUCHED_THING = 3
    TOUCHED_ROBOT = 4


CAMERA_GROUPS = frozenset({RenderGroup.FLOOR, RenderGroup.WORLD})
"""What a camera on the robot sees: neither the robot, nor shapes that are only touched."""

RANGE_GROUPS = frozenset({RenderGroup.TOUCHED_THING})
"""What a range sensor hears: neither the robot nor the floor."""


def flags(groups: Collection[RenderGroup]) -> list[bool]:
    """Return for each of MuJoCo's geom groups whether it is one of these."""
    from mujoco import mjNGROUP

    return [group in groups for group in range(mjNGROUP)]


_CAMERA = [0.5, 0.5, -0.5, -0.5]
"""A camera of MuJoCo's looks along its -z, with y up and x to the right; what is mounted, along its x, with z up."""


def about_z(angle: float) -> list[float]:
    """Return the quaternion of a turn to the left, in radians."""
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def mount_orientation(mount: Mount) -> list[float]:
    """Return the quaternion of what looks along its x axis: its pitch, then its yaw."""
    cy, sy = math.cos(mount.yaw_rad / 2), math.sin(mount.yaw_rad / 2)
    cp, sp = math.cos(mount.pitch_rad / 2), math.sin(mount.pitch_rad / 2)
    return [cy * cp, -sy * sp, cy * sp, sy * cp]


def camera_orientation(mount: Mount) -> list[float]:
    """Return the quaternion of a camera that is mounted so."""
    import mujoco

    quaternion = np.zeros(4)
    mujoco.mju_mulQuat(quaternion, np.array(mount_orientation(mount)), np.array(_CAMERA))
    return [float(part) for part in quaternion]


Colour = tuple[int, int, int]


def rgba(colour: Colour) -> list[float]:
    """Return a colour as MuJoCo takes it."""
    return [*(part / 255 for part in colour), 1.0]
