"""Attributes of a MuJoCo model: collision groups, render groups, orientations and colours."""

from __future__ import annotations

import math
from collections.abc import Collection
from enum import IntEnum, IntFlag

import numpy as np

from robotcore.description.devices import Mount


class CollisionGroup(IntFlag):
    """Bits of the attributes ``contype`` and ``conaffinity`` of a geom.

    Two geoms collide if the ``contype`` of one of them has a bit in common with the ``conaffinity`` of the other.
    """

    NOTHING = 0
    FLOOR = 1
    THING = 2


class RenderGroup(IntEnum):
    """The group of a geom, which decides whether cameras render it and range sensors detect it.

    A thing of the world has two geoms: a visual one, which is rendered, and a collision one, which has contacts.
    """

    FLOOR = 0
    WORLD = 1
    ROBOT = 2
    THING_COLLISION = 3
    ROBOT_COLLISION = 4


CAMERA_GROUPS = frozenset({RenderGroup.FLOOR, RenderGroup.WORLD})
"""The groups that the robot's cameras render: not the robot, and no collision geom."""

RANGE_GROUPS = frozenset({RenderGroup.THING_COLLISION})
"""The groups that range sensors detect: not the robot, and not the floor."""


def group_flags(groups: Collection[RenderGroup]) -> list[bool]:
    """Return a flag for each geom group of MuJoCo: true if the group is in ``groups``."""
    from mujoco import mjNGROUP

    return [group in groups for group in range(mjNGROUP)]


_MOUNT_TO_CAMERA = [0.5, 0.5, -0.5, -0.5]
"""The rotation from a mount's frame to the camera's, as a quaternion.

A mount points along its x axis and has z up. A camera of MuJoCo points along its -z axis and has y up, x right.
"""


def rotation_about_z(angle: float) -> list[float]:
    """Return the quaternion of a turn to the left (about the z axis) by an angle in radians."""
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def mount_orientation(mount: Mount) -> list[float]:
    """Return the orientation of a mount as a quaternion (w, x, y, z)."""
    cy, sy = math.cos(mount.yaw_rad / 2), math.sin(mount.yaw_rad / 2)
    cp, sp = math.cos(mount.pitch_rad / 2), math.sin(mount.pitch_rad / 2)
    return [cy * cp, -sy * sp, cy * sp, sy * cp]


def camera_orientation(mount: Mount) -> list[float]:
    """Return the orientation of a MuJoCo camera on a mount as a quaternion (w, x, y, z)."""
    import mujoco

    quaternion = np.zeros(4)
    mujoco.mju_mulQuat(quaternion, np.array(mount_orientation(mount)), np.array(_MOUNT_TO_CAMERA))
    return [float(part) for part in quaternion]


Colour = tuple[int, int, int]


def rgba(colour: Colour) -> list[float]:
    """Return an opaque colour as red, green, blue and alpha from 0 to 1. ``colour`` has parts from 0 to 255."""
    return [*(part / 255 for part in colour), 1.0]
