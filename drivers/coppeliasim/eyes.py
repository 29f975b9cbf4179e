"""What a built robot sees with: vision sensors for cameras and displays, and for a range sensor's fan."""

from __future__ import annotations

import math

from drivers.coppeliasim.placing import Placement
from drivers.coppeliasim.workshop import Workshop

NEAR_M, FAR_M = 0.01, 40.0
_EXPLICIT, _PERSPECTIVE, _OWN_BACKGROUND = 1, 2, 128


def longest(fov: float, width: int, height: int) -> float:
    """Return the perspective angle, which is that of a picture's longer side, for a horizontal field of view."""
    return fov if width >= height else 2 * math.atan(math.tan(fov / 2) * height / width)


def across(angle: float, width: int, height: int) -> float:
    """Return the horizontal field of view for a perspective angle."""
    return angle if width >= height else 2 * math.atan(math.tan(angle / 2) * width / height)


def add_vision_sensor(
    workshop: Workshop,
    alias: str,
    place: Placement,
    parent: int,
    size: tuple[int, int],
    fov: float,
    clip: tuple[float, float] = (NEAR_M, FAR_M),
    empty: float = 0.0,
    seen: int = -1,
) -> int:
    """Make a vision sensor that renders when it is told to.

    ``fov`` is horizontal, ``clip`` what is near and far, ``empty`` the grey, from 0 to 1, where nothing is, and
    ``seen`` the collection that it sees; -1 is all there is.
    """
    sensor = workshop.make(
        "createVisionSensor",
        _EXPLICIT | _PERSPECTIVE | _OWN_BACKGROUND,
        [*size, 0, 0],
        [*clip, longest(fov, *size), 0.02, 0, 0, empty, empty, empty, 0, 0],
    )
    workshop.set_int(sensor, "visionintparam_entity_to_render", seen)
    workshop.put(sensor, place, alias, parent)
    return sensor
