"""Quaternions of what is turned on the floor and on a robot, w first, as MuJoCo takes them."""

from __future__ import annotations

import math

from robotcore.description.devices import Mount

_CAMERA = [0.5, 0.5, -0.5, -0.5]
"""A camera of MuJoCo's looks along its -z, with y up and x to the right; what is mounted, along its x, with z up."""


def about_z(angle: float) -> list[float]:
    """Return the quaternion of a turn to the left, in radians."""
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def mounted(mount: Mount) -> list[float]:
    """Return the quaternion of what looks along its x axis: its pitch, then its yaw."""
    cy, sy = math.cos(mount.yaw_rad / 2), math.sin(mount.yaw_rad / 2)
    cp, sp = math.cos(mount.pitch_rad / 2), math.sin(mount.pitch_rad / 2)
    return [cy * cp, -sy * sp, cy * sp, sy * cp]


def looking(mount: Mount) -> list[float]:
    """Return the quaternion of a camera that is mounted so."""
    import mujoco
    import numpy as np

    quaternion = np.zeros(4)
    mujoco.mju_mulQuat(quaternion, np.array(mounted(mount)), np.array(_CAMERA))
    return [float(part) for part in quaternion]
