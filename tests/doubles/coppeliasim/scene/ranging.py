"""What proximity sensors detect: the fan of rays that every simulator here casts, in the sensor's own plane."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robotcore.raycast import Fan
from tests.doubles.coppeliasim.scene.objects import ProximitySensor
from tests.doubles.coppeliasim.scene.poses import Transform, Vector
from tests.doubles.coppeliasim.scene.rays import Solids

NEAREST_M = 0.001


class Detection(NamedTuple):
    """How far, in metres; where, and the surface's normal there, both in the sensor's frame; which object."""

    distance: float
    point: Vector
    handle: int
    normal: Vector


def detect(sensor: ProximitySensor, pose: Transform, solids: Solids) -> Detection | None:
    """Return what a sensor that looks along its z detects, or None.

    The point lies on the ray that came back first, as far away as is told: clients of the legacy API have no distance
    but the point's.
    """
    farthest = sensor.offset + sensor.reach
    angles = Fan(sensor.cone, sensor.offset, farthest).angles
    sideways, _, ahead = (np.array(axis) for axis in pose.axes)
    directions = np.outer(np.sin(angles), sideways) + np.outer(np.cos(angles), ahead)
    hits = solids.hits(np.array(pose.position) - sensor.setback * ahead, directions)
    ray = int(hits.lengths.argmin())
    if (distance := float(hits.lengths[ray]) - sensor.setback) > farthest:
        return None
    distance, angle = max(distance, sensor.offset, NEAREST_M), float(angles[ray])
    point = (distance * math.sin(angle), 0.0, distance * math.cos(angle))
    across, up, along = np.array(pose.axes) @ hits.normals[ray]
    return Detection(distance, point, solids.shapes[hits.solids[ray]].handle, (float(across), float(up), float(along)))
